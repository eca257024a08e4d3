#pragma once

#include <cstdint>
#include <span>
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

  /// Whether any error is drawn.
  bool is_random() const;
  static LidarNoise none();  ///< exact ranges, everything up to max_range_m is found
};

/// The errors of a built-in pattern's sensor; those of livox_avia for an unknown name.
LidarNoise noise_of(std::string_view pattern);

/// Standard deviation of a range [m] measured at an incidence of that cosine.
double range_sigma(const LidarNoise& noise, double range_m, double incidence_cos);

/// Strength of a pulse as it comes back: reflected exp(-2 a r) / r^2, `reflected` being reflectivity times
/// cosine.
double received_strength(const LidarNoise& noise, double range_m, double reflected);

/// The strength at the limit of detection: 0.1 / r10^2; 0 when r10_m is.
double detection_limit(const LidarNoise& noise);

/// The number a driver reports: 0..150 for diffuse surfaces of 0..100 %, 151..255 for retro-reflectors, whose
/// reflectivity is counted against a white diffuse surface; ours: logarithmic, 255 from a hundred times on.
float reported_intensity(double reflected);

/// The standard normal numbers that one beam's errors are made of.
struct BeamDraws {
  float aim_horizontal = 0, aim_vertical = 0, range = 0, detection = 0;
};
/// Draws of beams first..first + draws.size() - 1 of a scan (numbered from 0 in each scan).
void draw_beams(std::uint64_t seed, std::uint64_t scan, std::uint32_t first, std::span<BeamDraws> draws);

}  // namespace uniquadric
