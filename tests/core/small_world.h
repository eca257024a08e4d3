#pragma once

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <fstream>
#include <opencv2/core.hpp>

#include "core/base/files.h"
#include "core/sequence/sequence.h"
#include "core/sequence/trajectory.h"
#include "tests/support/recorded_world.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {

constexpr std::int64_t kStart_ns = 1'560'500'000'123'456'789, kFrame_ns = 33'333'333, kVicon_ns = 5'000'000;
constexpr int kWorldFrames = 5;

/// world_from_camera of the small world at a time: it moves and turns.
inline Eigen::Matrix4d small_camera(std::int64_t stamp_ns) {
  const double t = static_cast<double>(stamp_ns - kStart_ns) * 1e-9;
  return rigid({1, 2, -1}, 2 + 0.5 * t, {1 + 0.3 * t, -2 + 0.1 * t, 1.5 - 0.2 * t});
}
/// world_from_object of body `id`.
inline Eigen::Matrix4d small_object(int id, std::int64_t stamp_ns) {
  const double t = static_cast<double>(stamp_ns - kStart_ns) * 1e-9;
  return rigid({-1, 0.5, 2}, 0.7 * id + 0.4 * t, {0.5 * id, 1 - 0.4 * t, 0.8});
}

/// Five frames with poses every 5 ms that begin after the first frame, two bodies, an IMU.
inline RecordedWorld small_world() {
  RecordedWorld w;
  w.distortion = {0.01, -0.002, 0.0003, 0.0004};
  w.camera_from_imu = rigid({3, 1, 2}, 0.8, {0.05, -0.06, 0.07});
  for (int i = 0; i < kWorldFrames; ++i) {
    w.stamps_ns.push_back(kStart_ns + i * kFrame_ns);
    w.colors.emplace_back(w.height, w.width, CV_8UC3, cv::Scalar(10, 20 + i, 30));
    cv::Mat depth(w.height, w.width, CV_32FC1, cv::Scalar(7.25 + 0.5 * i));
    depth.at<float>(2, 3) = 0;
    w.depths_m.push_back(depth);
    cv::Mat ids(w.height, w.width, CV_16UC1, cv::Scalar(0));
    ids.at<std::uint16_t>(1, 4) = 1, ids.at<std::uint16_t>(5, 7) = 3;
    w.ids.push_back(ids);
  }
  for (std::int64_t t = kStart_ns + 10'000'000; t < w.stamps_ns.back() + 3 * kVicon_ns; t += kVicon_ns) {
    w.camera.push_back({t, small_camera(t)});
    for (const int id : {1, 3}) w.objects[id].push_back({t, small_object(id, t)});
    w.imu.push_back({t, {0.1, -0.2, 0.3}, {0.5, 9.7, static_cast<double>(t - kStart_ns) * 1e-9}});
  }
  return w;
}

/// Expects the small world's camera and rate in a sequence of that name.
inline void expect_small_camera(const Sequence& sequence, const std::string& name) {
  EXPECT_EQ(sequence.name, name);
  const Camera& camera = sequence.camera;
  EXPECT_EQ(camera.width, 8);
  EXPECT_EQ(camera.height, 6);
  EXPECT_EQ(camera.fx, 10);
  EXPECT_EQ(camera.fy, 11);
  EXPECT_EQ(camera.cx, 3.5);
  EXPECT_EQ(camera.cy, 2.5);
  EXPECT_EQ(camera.distortion, (std::array<double, 5>{0.01, -0.002, 0.0003, 0.0004, 0}));
  EXPECT_NEAR(sequence.rate_hz, 30, 1e-4);
}

/// Expects those of a motion, at the frames but the first.
template <typename Motion>
void expect_poses(const Trajectory& found, const Motion& world_from) {
  constexpr double kBetween = 1e-5;  // m: of the circle that a turning arm makes in 5 ms
  ASSERT_EQ(found.size(), kWorldFrames - 1u);
  for (int i = 1; i < kWorldFrames; ++i) {
    const StampedPose& pose = found[i - 1];
    EXPECT_EQ(pose.stamp_ns, kStart_ns + i * kFrame_ns);
    EXPECT_LT((pose.pose.matrix() - world_from(pose.stamp_ns)).cwiseAbs().maxCoeff(), kBetween) << i;
  }
}

/// Replaces the first `find` in a file.
inline void edit(const std::filesystem::path& file, const std::string& find, const std::string& by) {
  std::string text = read_text(file);
  ASSERT_NE(text.find(find), std::string::npos) << file << " has no " << find;
  write_text(file, text.replace(text.find(find), find.size(), by));
}

/// A damage to a recording and what must be said of it.
struct Refusal {
  std::string what;
  std::function<void(const std::filesystem::path&)> damage;
};

/// Expects each to be refused, and nothing at OUT. `import` takes SRC and OUT, `write` writes a whole one.
template <typename Write, typename Import>
void expect_refusals(const std::vector<Refusal>& cases, const Write& write, const Import& import) {
  for (const auto& [what, damage] : cases) {
    const TempFolder temp;
    const auto source = temp.path() / "recording", out = temp.path() / "out";
    write(source);
    damage(source);
    const std::string message = input_error([&] { import(source, out); });
    EXPECT_NE(message.find(what), std::string::npos) << message << "\nexpected: " << what;
    int left = 0;
    for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(temp.path())) ++left;
    EXPECT_EQ(left, 1) << what;  // the recording alone
  }
}

}  // namespace uniquadric
