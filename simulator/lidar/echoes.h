#pragma once

#include <optional>
#include <span>

#include "simulator/lidar/lidar_scan.h"

namespace uniquadric {

/// What one ray of a beam met.
struct RayReturn {
  double range_m = 0;
  double reflected = 0;  ///< reflectivity times cosine, over the number of the beam's rays
  float incidence_cos = 1;
  std::uint16_t instance = 0;
};

/// A pulse as the receiver sees it.
struct Echo {
  double range_m = 0;  ///< of a mixed echo: mean by strength
  double reflected = 0;
  double strength = 0;  ///< received_strength(), of all rays
  float incidence_cos = 1;
  std::uint16_t instance = 0;  ///< of the strongest ray
  bool mixed = false;  ///< of more than one surface: rays differ in range by more than a footprint's slope
  int number = 0;      ///< among the beam's echoes, from 0
};

/// The echo a sensor reports of a beam whose rays met `returns` (sorted here), nothing when none is found.
std::optional<Echo> reported_echo(std::span<RayReturn> returns, const LidarBeam& beam,
                                  const LidarNoise& noise, double limit);

}  // namespace uniquadric
