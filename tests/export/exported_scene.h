#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/sequence/sequence.h"
#include "core/sequence/tracks.h"
#include "harness/export/export.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {

using Matrix34d = Eigen::Matrix<double, 3, 4>;

/// Simulates a small scene of a moving box (id 1) and a ball at rest (id 2), with an IMU, and adds LiDAR
/// scans whose points lie on the ball's side towards the camera, each where it is at the scan's middle:
/// frames 1, 2 and 3 are taken then, frame 0 before the first scan.
class Export : public testing::Test {
 protected:
  static constexpr std::uint64_t kRosShift_ns = 1'000'000'000;
  static constexpr int kFrames = 4, kBox = 1, kBall = 2;

  Export();
  /// Exports to a new folder.
  std::filesystem::path run(const std::string& format, ExportOptions options = {});
  /// The truth's mask of a frame, 16UC1, read without the program's own reader.
  cv::Mat instances(int frame) const;
  /// The same for the sequence's images.
  cv::Mat sequence_image(const std::filesystem::path& file) const;
  const ObjectState& truth_of(int object, int frame) const;
  /// A frame's stamp in the formats of ROS: the scene begins at 0 s, which ROS takes for no time.
  std::uint64_t ros_stamp(std::size_t frame) const {
    return static_cast<std::uint64_t>(sequence_.frames[frame].stamp_ns) + kRosShift_ns;
  }
  void rewrite_index();  ///< after a change of `sequence`

  const std::filesystem::path& folder() const { return temp_.path(); }
  std::filesystem::path data() const { return folder() / "data"; }

  TempFolder temp_;
  Sequence sequence_;
  Tracks truth_;
  std::vector<std::vector<LidarPoint>> scans_;
};

/// How many messages each topic has; fails the test where they are not in order of `time_ns`.
template <typename Message>
std::map<std::string, int> topic_counts(const std::vector<Message>& messages,
                                        std::uint64_t Message::*time_ns) {
  std::map<std::string, int> counts;
  std::uint64_t last_ns = 0;
  for (const Message& message : messages) {
    ++counts[message.topic];
    EXPECT_GE(message.*time_ns, last_ns);
    last_ns = message.*time_ns;
  }
  return counts;
}

template <typename Message>
std::vector<Message> messages_of_topic(const std::vector<Message>& messages, const std::string& topic) {
  std::vector<Message> found;
  for (const Message& message : messages)
    if (message.topic == topic) found.push_back(message);
  return found;
}

/// Rows of a text file's fields, without those that begin with #.
std::vector<std::vector<std::string>> table(const std::filesystem::path& path, char separator);
/// The fields from `begin` on as numbers.
std::vector<double> numbers(const std::vector<std::string>& fields, std::size_t begin = 0);
/// Twelve numbers, row by row.
Matrix34d matrix34(const std::vector<double>& values);
/// Pixel of a homogeneous projection.
Eigen::Vector2d pixel_of(const Matrix34d& P, const Eigen::Vector3d& point);
/// The value of a 16-bit mask at the pixel that a point lies on; -1 outside the image.
int id_at(const cv::Mat& ids, const Eigen::Vector2d& pixel);
std::string bytes_of(const std::filesystem::path& path);

}  // namespace uniquadric
