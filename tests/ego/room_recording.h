#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "core/sequence/sequence.h"
#include "tests/ego/lidar_room.h"

namespace uniquadric {

/// What a recording of a LiDAR in a room has besides its scans.
struct RoomRecording {
  LidarRoom room;
  int scans = 20;
  bool has_imu = false;
  bool has_images = false;  ///< 80x60, grey noise, with masks of one body (id 1) in the middle, 20 a second
  std::int64_t lidar_clock_ns = 0;  ///< what its clock shows more than the camera's
  std::int64_t imu_clock_ns = 0;
  std::function<void(int scan, std::vector<LidarPoint>&)> change;  ///< of a scan before it is written
};

/// Forward, left, up to right, down, forward.
Eigen::Quaterniond camera_from_forward();

/// Writes the recording as a sequence folder; without images it is one of a LiDAR alone.
Sequence write_recording(const std::filesystem::path& folder, const RoomRecording& recording);

}  // namespace uniquadric
