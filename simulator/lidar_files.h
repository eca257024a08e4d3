#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "core/sequence/sequence.h"
#include "simulator/lidar/lidar_scan.h"
#include "simulator/scene/scene.h"
#include "simulator/simulate.h"
#include "simulator/stage_times.h"

namespace uniquadric {

/// The scene's LiDAR, when it has one. Throws InputError with the scene's file and line for a bad section.
std::optional<LidarRig> lidar_of(const Scene& scene);

/// The scans that end by the last of `frames` frames, by the names of their files in a sequence folder.
std::vector<SequenceScan> lidar_scans(const Scene& scene, const LidarRig& rig, std::int64_t frames);

/// Writes the scans to `folder`/sequence/lidar and what is true of their points to `folder`/truth/lidar;
/// scans whose files are there already are passed over, unless the method is depth_octree (octree_files.h).
/// Adds the times of `lidar`, or of that method's stages.
void write_lidar_files(const Scene& scene, const LidarRig& rig, const SimulateOptions& options,
                       std::int64_t frames, const std::filesystem::path& folder, StageTimes& times);

/// Files of one scan, the points written last: they say that it is complete.
struct ScanFiles {
  std::filesystem::path truth, points;
  bool complete() const;
};
ScanFiles scan_files(const std::filesystem::path& folder, std::size_t scan);
void write_scan(const ScanFiles& files, const LidarScan& scan, const Pose& world_from_lidar);

}  // namespace uniquadric
