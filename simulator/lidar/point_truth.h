#pragma once

#include <filesystem>
#include <vector>

#include "core/geometry/pose.h"
#include "simulator/lidar/lidar_scan.h"

namespace uniquadric {

/// What the simulator knows of a scan's points, in the order of its points' file, as PCD 0.7: range (F4, m,
/// without noise), incidence_cos (F4), instance (U2), kind (U1: 0 surface, 1 of several bodies, 2 false
/// alarm). The viewpoint is the sensor's pose at the scan's start.
void write_point_truth(const std::filesystem::path& path, const std::vector<LidarPointTruth>& truth,
                       const Pose& world_from_lidar);
std::vector<LidarPointTruth> read_point_truth(const std::filesystem::path& path);

}  // namespace uniquadric
