#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "core/sequence/sequence.h"
#include "simulator/lidar/lidar_scan.h"
#include "simulator/scene/scene.h"
#include "simulator/simulate.h"

namespace uniquadric {

/// The scene's LiDAR, when it has one. Throws InputError with the scene's file and line for a bad section.
std::optional<LidarRig> lidar_of(const Scene& scene);

/// The scans that end by the last of `frames` frames, by the names of their files in a sequence folder.
std::vector<SequenceScan> lidar_scans(const Scene& scene, const LidarRig& rig, std::int64_t frames);

/// Writes the scans to `folder`/sequence/lidar and what is true of their points to `folder`/truth/lidar;
/// scans whose files are there already are passed over. With the method depth_octree also
/// `folder`/truth/lidar_comparison.csv: each scan's ranges against Embree's over the same beams, without
/// noise (scan, beams, matched, lost, extra, mean_m, median_abs_m, p95_abs_m, rms_m).
void write_lidar_files(const Scene& scene, const LidarRig& rig, const SimulateOptions& options,
                       std::int64_t frames, const std::filesystem::path& folder);

}  // namespace uniquadric
