#include "simulator/lidar/lidar_noise.h"

#include <algorithm>
#include <array>
#include <cassert>
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
  noise.r10_m = noise.detection_sigma = noise.false_alarm = noise.crosstalk = noise.weak_bias_m = 0;
  noise.min_range_m = 0;
  return noise;
}

void scale_noise(LidarNoise& noise, double scale) {
  for (double* sigma :
       {&noise.range_sigma_m, &noise.divergence_deg, &noise.angle_sigma_deg, &noise.detection_sigma})
    *sigma *= scale;
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

RangeSpread::RangeSpread(const LidarNoise& noise)
    : sigma_(noise.range_sigma_m * noise.range_sigma_m),
      slope_(std::pow(noise.divergence_deg * (std::numbers::pi / 180), 2) / 12),
      most_tangent_(noise.max_incidence_tan * noise.max_incidence_tan) {}

double detection_limit(const LidarNoise& noise) {
  return noise.r10_m > 0 ? 0.1 / (noise.r10_m * noise.r10_m) : 0;
}

float reported_intensity(double reflected) {
  const double value = reflected <= 1 ? 150 * reflected : std::min(255.0, 151 + 52 * std::log10(reflected));
  return static_cast<float>(static_cast<int>(value + 0.5));
}

// A stream is shared by neighbouring beams: one of each its own would cost twice as much to start as to draw
// from.
void draw_beams(std::uint64_t seed, std::uint64_t scan, std::uint32_t first, int count, BeamDraws& draws) {
  constexpr std::uint32_t kGroup = 64;
  assert(count <= BeamDraws::kCapacity);
  const RandomStream scan_stream(seed, "lidar/beam", scan);
  std::array<float, 4 * kGroup> normals;
  const std::array<BeamDraws::Row*, 4> rows = {&draws.aim_horizontal, &draws.aim_vertical, &draws.range,
                                               &draws.detection};
  const std::uint32_t end = first + static_cast<std::uint32_t>(count);
  for (std::uint32_t beam = first; beam < end;) {
    RandomStream stream = scan_stream.at_element(beam / kGroup);
    fill_normals(stream, normals);
    const std::uint32_t from = beam % kGroup, n = std::min(kGroup - from, end - beam);
    for (std::size_t k = 0; k < rows.size(); ++k)
      std::copy_n(&normals[k * kGroup + from], n, rows[k]->begin() + (beam - first));
    beam += n;
  }
}

}  // namespace uniquadric
