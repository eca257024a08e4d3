#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "core/geometry/camera.h"
#include "core/geometry/superquadric.h"
#include "core/sequence/imu.h"
#include "core/sequence/lidar.h"
#include "harness/mcap/mcap_writer.h"

namespace uniquadric {

// Messages of ROS 2 (Humble and later) as CDR, and their types: std_msgs, sensor_msgs, tf2_msgs and
// visualization_msgs of https://github.com/ros2/common_interfaces and geometry2.

struct Ros2Header {
  std::int64_t stamp_ns = 0;
  std::string frame_id;
};

extern const McapSchema kImageSchema, kCameraInfoSchema, kPointCloudSchema, kImuSchema, kTransformsSchema,
    kMarkersSchema;

/// 8UC3 as bgr8, 32FC1 as 32FC1.
std::string image_message(const Ros2Header& header, const cv::Mat& image);
std::string camera_info_message(const Ros2Header& header, const Camera& camera);
/// Fields x, y, z, intensity (float32), t [ns after the stamp] (uint32), ring (uint16), tag (uint8).
std::string point_cloud_message(const Ros2Header& header, const std::vector<LidarPoint>& points);
std::string imu_message(const Ros2Header& header, const ImuSample& sample, const ImuCalibration& calibration);

struct Ros2Transform {
  Ros2Header header;  ///< its frame is the parent
  std::string child;
  Pose parent_from_child;
};
std::string transforms_message(const std::vector<Ros2Transform>& transforms);

/// A solid: a box, an ellipsoid, or the triangles of any other superellipsoid.
struct Ros2Solid {
  int id = 0;
  Pose pose;  ///< in the header's frame
  Superellipsoid body{Eigen::Vector3d::Ones()};
};
/// Replaces what the topic showed before. `color`: red, green, blue, opacity, 0 to 1.
std::string markers_message(const Ros2Header& header, const std::string& name,
                            const std::vector<Ros2Solid>& solids, const std::array<float, 4>& color);

}  // namespace uniquadric
