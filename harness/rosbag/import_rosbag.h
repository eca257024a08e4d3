#pragma once

#include <filesystem>
#include <string>

#include "core/import/recording.h"

namespace uniquadric {

/// Names of the topics of one camera, IMU and LiDAR.
struct BagTopicNames {
  std::string rgb, depth, camera_info, imu, lidar;
};

struct ImportRosbagOptions : ImportOptions {
  BagTopicNames topics;  ///< empty: found by type
  /// Sizes of the objects whose poses the bag has, an objects.yaml as a truth has it. Empty: the truth is of
  /// the camera alone.
  std::filesystem::path objects;
};

/// Turns a ROS 1 bag into `out`/sequence and, where it has poses as `export rosbag` writes them, `out`/truth.
/// Stamps are those of the messages' headers. Extrinsics are those of /tf_static, else the identity, which a
/// line on stderr says. Throws InputError, with the topic and message, for what is missing or malformed; then
/// nothing is left at `out`.
void import_rosbag(const std::filesystem::path& bag, const ImportRosbagOptions& options,
                   const std::filesystem::path& out);

}  // namespace uniquadric
