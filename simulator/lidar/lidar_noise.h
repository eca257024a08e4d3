#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string_view>

namespace uniquadric {

/// A LiDAR's errors. What is left at 0 is not simulated.
struct LidarNoise {
  double range_sigma_m = 0.02;  ///< sigma_0 (data sheets of Livox and OS1)
  /// gamma of the incidence term: sigma^2 = sigma_0^2 + (r gamma tan(theta) / sqrt 12)^2
  double divergence_deg = 0.28;
  double max_incidence_tan = 11.43;  ///< ours: the term stops growing at 85 deg; footprints end somewhere
  double angle_sigma_deg = 0.05;  ///< of the beam's true direction about the reported one, a transverse axis
  double quantum_m = 0.001;       ///< ranges are multiples of it
  double min_range_m = 0.1;       ///< nothing nearer or farther is reported
  double max_range_m = 450;
  /// A surface of reflectivity 0.1 met head-on at this range returns a pulse at the limit of detection.
  double r10_m = 190;
  double extinction_per_m = 0;   ///< a of exp(-2 a r); ours: clear air
  double detection_sigma = 0.1;  ///< ours: of the limit, relative; half the pulses at it are found
  double false_alarm = 1e-4;     ///< probability a beam, at a range evenly between the least and the most
  double crosstalk = 0;          ///< probability that a beam takes the echo of the one before it for its own
  double weak_bias_m = 0;        ///< added to the range of what reflects nothing, less the more it reflects

  /// Whether any error is drawn.
  bool is_random() const;
  static LidarNoise none();  ///< exact ranges, everything up to max_range_m is found
};

/// Multiplies the amplitudes of the errors: range_sigma_m, divergence_deg, angle_sigma_deg, detection_sigma.
void scale_noise(LidarNoise& noise, double scale);

/// The errors of a built-in pattern's sensor; those of livox_avia for an unknown name.
LidarNoise noise_of(std::string_view pattern);

/// sigma^2 = sigma_0^2 + (r gamma tan(theta) / sqrt 12)^2, its constants squared once.
class RangeSpread {
 public:
  explicit RangeSpread(const LidarNoise& noise);
  /// Standard deviation of a range [m] measured at an incidence of that cosine.
  double sigma_m(double range_m, double incidence_cos) const {
    const double square = std::max(incidence_cos * incidence_cos, 1e-18);
    const double tangent = std::min((1 - std::min(square, 1.0)) / square, most_tangent_);
    return std::sqrt(sigma_ + slope_ * (range_m * range_m) * tangent);
  }

 private:
  double sigma_, slope_, most_tangent_;  // squares
};

/// Strength of a pulse as it comes back: reflected exp(-2 a r) / r^2, `reflected` being reflectivity times
/// cosine.
inline double received_strength(const LidarNoise& noise, double range_m, double reflected) {
  const double haze = noise.extinction_per_m > 0 ? std::exp(-2 * noise.extinction_per_m * range_m) : 1;
  return reflected * haze / (range_m * range_m);
}

/// The strength at the limit of detection: 0.1 / r10^2; 0 when r10_m is.
double detection_limit(const LidarNoise& noise);

/// The number a driver reports: 0..150 for diffuse surfaces of 0..100 %, 151..255 for retro-reflectors, whose
/// reflectivity is counted against a white diffuse surface; ours: logarithmic, 255 from a hundred times on.
float reported_intensity(double reflected);

/// The standard normal numbers that beams' errors are made of, an array a kind.
struct BeamDraws {
  static constexpr int kCapacity = 256;
  using Row = std::array<float, kCapacity>;
  alignas(32) Row aim_horizontal, aim_vertical, range, detection;
};
/// Draws of `count` beams from `first` on (numbered from 0 in each scan): a beam's depend on (seed, scan,
/// beam) alone. Asserts that they fit.
void draw_beams(std::uint64_t seed, std::uint64_t scan, std::uint32_t first, int count, BeamDraws& draws);

}  // namespace uniquadric
