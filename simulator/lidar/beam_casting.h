#pragma once

#include <cstdint>

#include "simulator/lidar/lidar_scan.h"

namespace uniquadric {

/// What all beams of one scan share.
struct BeamCasting {
  const LidarRig& rig;
  const SensorPath& path;
  const CasterScan& bodies;
  std::uint64_t seed = 0;
  std::int64_t scan = 0, start_ns = 0, end_ns = 0;
};

/// Casts beams from..from + count - 1 of the scan, whose beam 0 is the pattern's beam `first`, and writes the
/// points they give (at most one a beam) with their truth; returns how many.
int cast_beams(const BeamCasting& casting, std::int64_t first, std::int64_t from, int count,
               LidarPoint* points, LidarPointTruth* truth);

}  // namespace uniquadric
