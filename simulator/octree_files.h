#pragma once

#include <filesystem>

#include "simulator/lidar/lidar_scan.h"
#include "simulator/scene/scene.h"
#include "simulator/simulate.h"
#include "simulator/stage_times.h"

namespace uniquadric {

/// Full angles in which a second of a pattern's beams lies, both sides of x alike.
struct FieldOfView {
  double horizontal_deg = 0, vertical_deg = 0;
};
FieldOfView field_of_view(const ScanPattern& pattern);

/// Writes `count` scans in the paper's way (method depth_octree): one depth image at each scan's start stands
/// for the whole scan. Beside the scans' files, in `folder`/truth, against Embree's ranges over the same
/// beams without noise: lidar_comparison.csv, a row a scan (scan, beams, matched, lost, extra, mean_m,
/// median_abs_m, p95_abs_m, rms_m), and lidar_errors.csv, a histogram of all scans' errors (from_m, to_m,
/// beams; the outer cells' open ends are empty). Adds the times of `lidar_octree` and `lidar_embree`, one
/// thread each.
void write_octree_scans(Scene scene, const LidarRig& rig, const SimulateOptions& options, std::size_t count,
                        const std::filesystem::path& folder, StageTimes& times);

}  // namespace uniquadric
