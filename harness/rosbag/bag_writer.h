#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "core/geometry/camera.h"
#include "core/sequence/imu.h"
#include "core/sequence/lidar.h"
#include "harness/rosbag/bag_message.h"

namespace uniquadric {

/// Writes the messages of a ROS 1 bag (format 2.0, chunks not compressed). `record_ns` is the time that
/// players go by. Throws std::runtime_error when the file cannot be written. This header and its source are
/// C++17: ROS 1's message headers are no C++20.
class BagWriter {
 public:
  explicit BagWriter(const std::filesystem::path& path);
  ~BagWriter();

  /// sensor_msgs/Image: CV_8UC3 as bgr8, CV_32FC1 as 32FC1.
  void image(const std::string& topic, const BagHeader& header, const cv::Mat& image);
  /// sensor_msgs/CameraInfo, plumb_bob.
  void camera_info(const std::string& topic, const BagHeader& header, const Camera& camera);
  /// sensor_msgs/Imu, without orientation. The covariances are those of white noise at the IMU's rate.
  void imu(const std::string& topic, const BagHeader& header, const ImuSample& sample,
           const ImuCalibration& calibration);
  /// sensor_msgs/PointCloud2: x y z intensity (float32), t (uint32, ns), time (float32, s), ring (uint16),
  /// tag (uint8).
  void point_cloud(const std::string& topic, const BagHeader& header, std::int64_t record_ns,
                   const std::vector<LidarPoint>& points);
  /// livox_ros_driver/CustomMsg; reflectivity is the intensity, rounded.
  void livox(const std::string& topic, const BagHeader& header, std::int64_t record_ns,
             const std::vector<LidarPoint>& points);
  /// geometry_msgs/PoseStamped: pose of something in the frame of the header.
  void pose(const std::string& topic, const BagHeader& header, const Pose& pose);
  /// tf2_msgs/TFMessage on /tf_static, latched.
  void static_transforms(std::int64_t stamp_ns, const std::vector<BagTransform>& transforms);

  void close();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace uniquadric
