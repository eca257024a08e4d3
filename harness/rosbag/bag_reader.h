#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "core/geometry/camera.h"
#include "core/sequence/imu.h"
#include "core/sequence/lidar.h"
#include "core/sequence/pcd.h"
#include "harness/rosbag/bag_message.h"

namespace uniquadric {

struct BagTopic {
  std::string name, type;
  std::size_t messages = 0;
};

/// sensor_msgs/Image: its pixels as they are; or sensor_msgs/CompressedImage: the bytes of its file.
struct BagImage {
  std::string encoding;  ///< of an Image ("bgr8"); a CompressedImage's format
  cv::Mat pixels;        ///< CV_8UC1, CV_8UC3, CV_8UC4, CV_16UC1 or CV_32FC1; empty for other encodings
  std::string file;      ///< of a CompressedImage
};

/// sensor_msgs/Imu.
struct BagImu {
  ImuSample sample;                                                   ///< without stamp
  double angular_velocity_variance = 0, specific_force_variance = 0;  ///< of x; not above 0: not known
};

/// Reads the messages of a ROS 1 bag (format 2.0, any compression) by topic and place in time. Throws
/// InputError naming the file, and the topic and message, for what is no bag, is truncated or is of another
/// definition than the type's. This header and its source are C++17: ROS 1's message headers are no C++20.
class BagReader {
 public:
  explicit BagReader(const std::filesystem::path& path);
  ~BagReader();

  const std::filesystem::path& path() const { return path_; }
  std::vector<BagTopic> topics() const;  ///< in order of names
  /// Of any message that begins with a header.
  BagHeader header(const std::string& topic, std::size_t message) const;
  BagImage image(const std::string& topic, std::size_t message) const;
  /// sensor_msgs/CameraInfo: plumb_bob, with up to five coefficients.
  Camera camera_info(const std::string& topic, std::size_t message) const;
  BagImu imu(const std::string& topic, std::size_t message) const;
  /// sensor_msgs/PointCloud2 as a file of points; fields of several values are left out.
  PcdFile point_cloud(const std::string& topic, std::size_t message) const;
  /// livox_ros_driver/CustomMsg.
  std::vector<LidarPoint> livox(const std::string& topic, std::size_t message) const;
  /// geometry_msgs/PoseStamped.
  Pose pose(const std::string& topic, std::size_t message) const;
  /// Of all messages on /tf_static.
  std::vector<BagTransform> static_transforms() const;

 private:
  struct Impl;
  std::filesystem::path path_;
  std::unique_ptr<Impl> impl_;
};

}  // namespace uniquadric
