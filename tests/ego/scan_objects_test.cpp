#include "estimator/perception/scan_objects.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <set>

#include "core/base/files.h"
#include "core/sequence/tracks.h"
#include "core/sequence/trajectory.h"
#include "estimator/estimate.h"
#include "tests/ego/lidar_room.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
using Eigen::Vector3d;

// A box comes through a room towards a swaying LiDAR, which has no camera.
class LidarAlone : public testing::Test {
 protected:
  LidarAlone() {
    room_.pattern = LidarRoom::Pattern::forward;
    room_.points = 20'000;
    room_.range_sigma_m = 0.01;
    room_.vigour = 0.3;
    room_.mover_half_m = {0.7, 0.5, 0.6};
    room_.half_size_m.x() = 12;
    room_.mover_start_m = {9, -1.4, -1.88};
    room_.mover_velocity_mps = {-1.5, 0, 0};
    Sequence sequence;
    sequence.name = "room";
    sequence.rate_hz = 10;
    sequence.lidar.emplace();
    sequence.lidar->pattern = "forward";
    sequence.lidar->camera_from_lidar = {Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5), {0.1, 0.2, -0.05}};
    std::filesystem::create_directories(temp_.path() / "sequence/lidar");
    for (int i = 0; i < kScans; ++i) {
      sequence.scans.push_back({room_.scan_start_ns(i), fmt::format("lidar/{}.pcd", i)});
      write_lidar_points(folder() / sequence.scans.back().file, room_.scan(i));
    }
    write_sequence_index(folder(), sequence);
    std::filesystem::remove(folder() / "rgb.txt");
    variant_ =
        load_variant(std::filesystem::path(UNIQUADRIC_SOURCE_DIR) / "configs/variants/lidar_only.yaml");
    variant_.perception.scan_objects.clusters.tolerance_m = 0.3;
    variant_.perception.scan_objects.clusters.max_extent_m = 4;
  }
  std::filesystem::path folder() const { return temp_.path() / "sequence"; }
  Pose room_from_camera(std::int64_t stamp_ns) const {
    return room_.world_from_lidar(1e-9 * static_cast<double>(stamp_ns)) *
           open_sequence(folder()).lidar->camera_from_lidar.inverse();
  }
  // Distance of a point from the moving box's surface.
  double off_mover_m(const Vector3d& point, std::int64_t stamp_ns) const {
    const Eigen::Array3d off = (point - room_.mover_m(1e-9 * static_cast<double>(stamp_ns))).array().abs() -
                               room_.mover_half_m.array();
    return off.maxCoeff() > 0 ? off.max(0).matrix().norm() : -off.maxCoeff();
  }

  // The rectangle about the mover in the camera's image.
  cv::Rect box_of_mover(const Camera& camera, std::int64_t stamp_ns) const {
    std::vector<cv::Point2f> corners;
    for (int i = 0; i < 8; ++i) {
      const Vector3d sign(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
      const Vector3d corner = room_.mover_start_m + sign.cwiseProduct(room_.mover_half_m);
      const auto pixel = camera.project(room_from_camera(stamp_ns).inverse() * corner);
      corners.emplace_back(static_cast<float>(pixel.value().x()), static_cast<float>(pixel.value().y()));
    }
    return cv::boundingRect(corners);
  }

  // The mover rests before a camera, whose images show it red and near before grey, with its masks or without
  // them. Its box in one of them.
  cv::Rect rest_before_images(bool with_masks) {
    room_.mover_velocity_mps = Vector3d::Zero();
    Sequence sequence = open_sequence(folder());
    for (int i = 0; i < kScans; ++i) write_lidar_points(folder() / sequence.scans[i].file, room_.scan(i));
    sequence.camera = scan_camera({});
    sequence.depth_units_per_m = 1000;
    const cv::Size size(sequence.camera.width, sequence.camera.height);
    for (const char* name : {"rgb", "depth", "masks"}) std::filesystem::create_directories(folder() / name);
    for (int i = 0; i < kScans; ++i) {
      SequenceFrame frame;
      frame.frame = i;
      frame.stamp_ns = frame.masks_arrival_ns = room_.scan_start_ns(i + 1);
      const cv::Rect box = box_of_mover(sequence.camera, frame.stamp_ns);
      cv::Mat image(size, CV_8UC3, cv::Scalar(90, 90, 90)), mask(size, CV_16UC1, cv::Scalar(0));
      image(box) = cv::Scalar(20, 20, 200);
      mask(box) = 1;
      const double away_m = (room_from_camera(frame.stamp_ns).inverse() * room_.mover_start_m).z();
      cv::Mat depth(size, CV_16UC1, cv::Scalar(2 * away_m * sequence.depth_units_per_m));
      depth(box) = cv::Scalar(away_m * sequence.depth_units_per_m);
      frame.rgb = fmt::format("rgb/{}.png", i);
      frame.depth = fmt::format("depth/{}.png", i);
      write_png(folder() / frame.rgb, image);
      write_png(folder() / frame.depth, depth);
      if (with_masks) write_png(folder() / (frame.masks = fmt::format("masks/{}.png", i)), mask);
      sequence.frames.push_back(frame);
    }
    write_sequence_index(folder(), sequence);
    return box_of_mover(sequence.camera, sequence.frames[kPrompted].stamp_ns);
  }

  // The estimate has the mover at its place, in nearly all scans from one on, and nothing else; or nothing at
  // all.
  void expect_mover_alone(bool is_found, const Prompts& prompts = {}, int from = 0) {
    EstimateOptions options;
    options.quiet = true;
    options.threads = 1;
    options.prompts = prompts;
    variant_.plausibility.enabled = false;
    const auto out = temp_.path() / (is_found ? "found" : "none");
    estimate(folder(), variant_, options, out);
    const Tracks tracks = read_tracks(out);
    const Pose room_from_world =
        room_from_camera(tracks.camera.back().stamp_ns) * tracks.camera.back().pose.inverse();
    const auto is_mover = [&](const ObjectTrack& track) {
      const Ellipsoid& last = track.states.back().ellipsoid;
      return std::ssize(track.states) >= kScans - from - 4 &&
             (room_from_world * last.world_from_object.translation - room_.mover_start_m).norm() < 0.3;
    };
    EXPECT_EQ(std::ssize(tracks.objects), is_found ? 1 : 0);
    EXPECT_EQ(std::ranges::count_if(tracks.objects, is_mover), is_found ? 1 : 0);
  }

  static constexpr int kScans = 26, kPrompted = 5;
  TempFolder temp_;
  LidarRoom room_;
  Variant variant_;
};

TEST_F(LidarAlone, PointsOfTheBodyLieOnItAtTheScansEnd) {
  EstimateOptions options;
  options.quiet = true;
  options.threads = 1;
  options.perception = temp_.path() / "perception";
  keep_perception(folder(), variant_, options);
  const Perception perception(options.perception);
  std::set<int> ids;
  int seen = 0;
  std::vector<double> off_m;
  for (std::size_t i = 0; i < perception.frames().size(); ++i) {
    const PerceivedFrame frame = perception.read(i);
    EXPECT_EQ(frame.stamp_ns, room_.scan_start_ns(static_cast<int>(i) + 1));
    for (const BodyObservation& body : frame.bodies) {
      ids.insert(body.id);
      ++seen;
      EXPECT_EQ(std::ssize(body.cut), body.points.cols());
      EXPECT_GT(body.points.cols(), 100);
      EXPECT_GE(body.known_at_frame, frame.frame);
      const Pose pose = room_from_camera(frame.stamp_ns);
      for (const auto& p : body.points.colwise())
        off_m.push_back(off_mover_m(pose * Vector3d(p), frame.stamp_ns));
    }
  }

  EXPECT_EQ(ids.size(), 1u);
  EXPECT_GE(seen, kScans - 8);
  ASSERT_FALSE(off_m.empty());
  std::sort(off_m.begin(), off_m.end());
  constexpr double kOff = 0.02;  // m: without its motion undone the front is 75 mm off in the middle
  EXPECT_LT(off_m[off_m.size() / 2], kOff);
}

TEST_F(LidarAlone, TheBodyIsFoundWithItsSize) {
  EstimateOptions options;
  options.quiet = true;
  options.threads = 1;
  const auto out = temp_.path() / "estimate";
  estimate(folder(), variant_, options, out);
  const Tracks tracks = read_tracks(out / "final");
  ASSERT_EQ(tracks.objects.size(), 1u);
  const ObjectTrack& track = tracks.objects[0];
  EXPECT_GE(std::ssize(track.states), kScans - 4);  // once it is known to move, it has been seen before
  EXPECT_LT(read_tracks(out).objects[0].states.size(), track.states.size());
  const ObjectState& last = track.states.back();
  std::array<double, 3> axes, truth{0.5, 0.6, 0.7};
  std::copy_n(last.ellipsoid.semi_axes_m.data(), 3, axes.begin());
  std::sort(axes.begin(), axes.end());
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(axes[i], truth[i], 0.15);
  // the step from first to last is free of what the world's origin is
  const Vector3d step = tracks.camera.back().pose.rotation.conjugate() *
                        (last.ellipsoid.world_from_object.translation -
                         track.states.front().ellipsoid.world_from_object.translation);
  const double time_s = 1e-9 * static_cast<double>(last.stamp_ns - track.states.front().stamp_ns);
  const Vector3d expected =
      room_from_camera(last.stamp_ns).rotation.conjugate() * (time_s * room_.mover_velocity_mps);
  EXPECT_LT((step - expected).norm(), 0.1);
}

// What rests is a body under a mask alone.
TEST_F(LidarAlone, WhatRestsUnderAMaskIsABody) {
  rest_before_images(true);
  for (const bool masks : {false, true}) {
    variant_.perception.scan_objects.masks = masks;
    expect_mover_alone(masks);
  }
}

// A segmenter that looks at colours gets them, though nothing else reads them.
TEST_F(LidarAlone, ABoxInAnImageTellsWhatIsABody) {
  const cv::Rect box = rest_before_images(false);
  const auto prompts = temp_.path() / "prompts.txt";
  write_text(prompts, fmt::format("{} {} {} {} {} 1\n", format_stamp(room_.scan_start_ns(kPrompted + 1)),
                                  box.x, box.y, box.width, box.height));
  variant_.perception.scan_objects.masks = true;
  expect_mover_alone(true, prompts, kPrompted);
}

TEST_F(LidarAlone, ABoxWithoutAMaskIsSaid) {
  rest_before_images(false);
  const auto prompts = temp_.path() / "prompts.txt";
  write_text(prompts, fmt::format("{} 10 10 40 30 1\n", format_stamp(room_.scan_start_ns(kPrompted + 1))));
  variant_.perception.scan_objects.masks = true;
  testing::internal::CaptureStderr();
  expect_mover_alone(false, prompts);
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_NE(said.find("prompts.txt: object 1: the box (10, 10, 40, 30)"), std::string::npos) << said;
  EXPECT_NE(said.find("gave no mask"), std::string::npos) << said;
}

}  // namespace
}  // namespace uniquadric
