#pragma once

#include "simulator/lidar/lidar_scan.h"

namespace uniquadric {

/// What a block's beams report, at most one echo a beam.
struct EchoBlock {
  template <typename T>
  using Row = std::array<T, RayBlock::kCapacity>;
  alignas(32) Row<double> range_m, measured_m;  ///< without and with its error, in the sensor's steps
  alignas(32) Row<double> reflected;            ///< reflectivity times cosine
  Row<bool> is_found, is_mixed;
  Row<float> incidence_cos;
  Row<std::uint16_t> instance;
  Row<std::uint8_t> number;
};

/// The echoes of beams whose rays (rig.beam.rays() each, beam after beam) have been cast.
void find_echoes(const LidarRig& rig, const RayBlock& rays, const BeamDraws& draws, EchoBlock& echoes);

}  // namespace uniquadric
