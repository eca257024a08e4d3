#include "simulator/lidar/lidar_noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/base/random.h"
#include "simulator/noise/normals.h"

namespace uniquadric {

bool LidarNoise::is_random() const {
  return range_sigma_m > 0 || divergence_deg > 0 || angle_sigma_deg > 0 || detection_sigma > 0;
}

LidarNoise LidarNoise::none() {
  LidarNoise noise;
  noise.range_sigma_m = noise.divergence_deg = noise.angle_sigma_deg = noise.quantum_m = 0;
  noise.r10_m = noise.detection_sigma = noise.false_alarm = 0;
  noise.min_range_m = 0;
  return noise;
}

LidarNoise noise_of(std::string_view pattern) {
  struct Row {
    std::string_view pattern;
    double range_sigma_m, angle_sigma_deg, r10_m, max_range_m;
  };
  // Spinning sensors: no angle error is published; ours: R10 of theirs, 100 m, as for the Livox of that
  // class.
  static constexpr std::array<Row, 8> kRows = {{{"livox_avia", 0.02, 0.05, 190, 450},
                                                {"livox_horizon", 0.02, 0.05, 90, 260},
                                                {"livox_mid40", 0.02, 0.1, 90, 260},
                                                {"livox_mid70", 0.02, 0.1, 90, 260},
                                                {"livox_mid360", 0.02, 0.15, 40, 70},
                                                {"vlp16", 0.03, 0, 100, 100},
                                                {"hdl64e", 0.02, 0, 100, 120},
                                                {"os1_64", 0.02, 0, 100, 120}}};
  LidarNoise noise;
  for (const Row& row : kRows)
    if (row.pattern == pattern) {
      noise.range_sigma_m = row.range_sigma_m;
      noise.angle_sigma_deg = row.angle_sigma_deg;
      noise.r10_m = row.r10_m;
      noise.max_range_m = row.max_range_m;
    }
  return noise;
}

double range_sigma(const LidarNoise& noise, double range_m, double incidence_cos) {
  const double c = std::max(incidence_cos, 1e-9);
  const double tangent = std::min(std::sqrt(std::max(0.0, 1 - c * c)) / c, noise.max_incidence_tan);
  const double spread = range_m * noise.divergence_deg * (std::numbers::pi / 180) * tangent;
  return std::sqrt(noise.range_sigma_m * noise.range_sigma_m + spread * spread / 12);
}

double received_strength(const LidarNoise& noise, double range_m, double reflected) {
  const double haze = noise.extinction_per_m > 0 ? std::exp(-2 * noise.extinction_per_m * range_m) : 1;
  return reflected * haze / (range_m * range_m);
}

double detection_limit(const LidarNoise& noise) {
  return noise.r10_m > 0 ? 0.1 / (noise.r10_m * noise.r10_m) : 0;
}

float reported_intensity(double reflected) {
  const double value = reflected <= 1 ? 150 * reflected : std::min(255.0, 151 + 52 * std::log10(reflected));
  return static_cast<float>(static_cast<int>(value + 0.5));
}

void draw_beams(std::uint64_t seed, std::uint64_t scan, std::uint32_t first, std::span<BeamDraws> draws) {
  const RandomStream scan_stream(seed, "lidar/beam", scan);
  for (std::size_t i = 0; i < draws.size(); ++i) {
    RandomStream stream = scan_stream.at_element(first + static_cast<std::uint32_t>(i));
    std::array<float, 4> normals;
    fill_normals(stream, normals);
    draws[i] = {normals[0], normals[1], normals[2], normals[3]};
  }
}

}  // namespace uniquadric
