// Points that were out of sight come back under their old ids.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>
#include <set>

#include "drawn_world.h"
#include "estimator/ego/rgbd_odometry.h"
#include "estimator/features/features.h"

namespace uniquadric {
namespace {

SequenceFrame frame_at(int i) {
  SequenceFrame frame;
  frame.frame = i;
  frame.stamp_ns = i * 33'333'333LL;
  return frame;
}

struct Hidden {
  std::vector<DrawnCard> box = box_cards(3, {0.5, 0.4, 0.3}, 21);
  DrawnCard wall{0, {6, 5}, block_texture(900, 6), {exp_so3({0.1, 0.15, 0}), {0, 0, 2.8}}};

  static Pose camera_from_box(int i) {
    return {exp_so3({0.5 + 0.015 * i, 0.6 - 0.02 * i, 0.1}), {0.1 + 0.004 * i, 0.02, 1.5}};
  }
  DrawnFrame frame(int i, bool with_box) const {
    auto cards = with_box ? moved(box, camera_from_box(i)) : std::vector<DrawnCard>{};
    cards.push_back(wall);
    return draw(small_camera(), cards, {0.005, 2}, i);
  }
};

TEST(TrackReturn, ABodyIsRecognisedAfterAnOcclusionWhileItTurned) {
  const Hidden world;
  FeatureTracker tracker(small_camera(), {}, 1);
  std::map<std::int64_t, Eigen::Vector3d> points;  // of the box, where each was first seen
  const auto look = [&](int i, bool with_box) {
    const auto frame = world.frame(i, with_box);
    const auto seen = tracker.track(frame_at(i), frame.gray, frame.depth, frame.masks);
    if (!with_box) return std::pair(0, 0);
    int old = 0, right = 0;
    for (const auto& f : seen.bodies.at(3)) {
      const int u = int(std::lround(f.pixel.x())), v = int(std::lround(f.pixel.y()));
      const Pose pose = Hidden::camera_from_box(i);
      if (!points.contains(f.track)) {
        points[f.track] =
            pose.inverse() * (double(frame.true_depth.at<float>(v, u)) * *small_camera().unproject(f.pixel));
        continue;
      }
      ++old;
      right += (*small_camera().project(pose * points[f.track]) - f.pixel).norm() < 1;
    }
    return std::pair(old, right);
  };
  for (int i = 0; i < 5; ++i) look(i, true);
  for (int i = 5; i < 15; ++i) EXPECT_EQ(look(i, false).first, 0);
  const auto before = points.size();
  EXPECT_GT(before, 30u);
  look(15, true);
  const auto [old, right] =
      look(16, true);  // those that the first frame recognised, and more by their places
  EXPECT_GT(points.size(), before);
  int returned = 0;
  const auto frame = world.frame(17, true);
  const auto seen = tracker.track(frame_at(17), frame.gray, frame.depth, frame.masks);
  for (const auto& f : seen.bodies.at(3)) returned += f.track < std::int64_t(1e9) && points.contains(f.track);
  EXPECT_GT(old, 20);
  EXPECT_GT(right, 0.9 * old);
  EXPECT_GT(returned, 20);
  EXPECT_TRUE(seen.motions.contains(3));
}

TEST(TrackReturn, TheBackgroundIsRecognisedAfterBlackFrames) {
  const Hidden world;
  FeatureTracker tracker(small_camera(), {}, 1);
  std::set<std::int64_t> ids;
  for (int i = 0; i < 4; ++i) {
    const auto frame = world.frame(i, false);
    const auto seen = tracker.track(frame_at(i), frame.gray, frame.depth, frame.masks);
    for (const auto& f : seen.background) ids.insert(f.track);
  }
  const cv::Mat black = cv::Mat::zeros(240, 320, CV_8UC1), nothing = cv::Mat::zeros(240, 320, CV_32FC1);
  for (int i = 4; i < 7; ++i) EXPECT_TRUE(tracker.track(frame_at(i), black, nothing, {}).background.empty());
  const auto frame = world.frame(7, false);
  const auto seen = tracker.track(frame_at(7), frame.gray, frame.depth, frame.masks);
  int old = 0;
  for (const auto& f : seen.background) old += ids.contains(f.track);
  EXPECT_GT(old, 30);
}

// Looks at a wall of equal tiles: the descriptors of one fit all others as well. `blur_px`: of frames 12
// to 16.
struct Blinded {
  Hidden world;
  FeatureTracker tracker;
  RgbdOdometry odometry{small_camera(), {}, 1};
  std::set<int> lost;  // frames

  Blinded(double blur_px, const FeatureOptions& options) : tracker(small_camera(), options, 1) {
    cv::Mat tile(112, 112, CV_32FC1, cv::Scalar(110));
    tile(cv::Rect(20, 24, 40, 16)).setTo(200);
    tile(cv::Rect(44, 56, 22, 36)).setTo(20);
    cv::repeat(tile, 8, 8, world.wall.texture);
    for (int i = 0; i < 25; ++i) {
      world.wall.camera_from_card.translation.x() = 0.003 * i;
      DrawnFrame frame = world.frame(i, false);
      if (i >= 12 && i < 17) cv::GaussianBlur(frame.gray, frame.gray, {}, blur_px);
      const auto seen = tracker.track(frame_at(i), frame.gray, frame.depth, frame.masks);
      odometry.track(frame_at(i), seen, frame.depth, frame.masks);
      if (!odometry.pose()) lost.insert(i);
    }
  }
};

TEST(TrackReturn, ABlindCameraFindsItselfInItsMap) {
  for (const double blur_px : {7, 15}) {
    const Blinded run(blur_px, {});
    EXPECT_TRUE(run.lost.contains(16)) << blur_px;
    EXPECT_EQ(run.lost.upper_bound(16), run.lost.end()) << blur_px;
    EXPECT_EQ(run.odometry.restarts(), 0);
    const Trajectory trajectory = run.odometry.trajectory();
    ASSERT_GE(trajectory.size(), 20u);
    const Pose moved = relative_pose(trajectory.front().pose, trajectory.back().pose);
    EXPECT_LT((moved.translation - Eigen::Vector3d(-0.072, 0, 0)).norm(), 0.01);
  }
}

TEST(TrackReturn, WithoutALookWhereItLeftABlindCameraStaysLost) {
  FeatureOptions options;
  options.gallery.look_where_left = false;
  EXPECT_TRUE(Blinded(15, options).lost.contains(24));
}

// Another body under the same label is not taken for the old one.
TEST(TrackReturn, AnotherBodyIsNotRecognised) {
  Hidden world;
  FeatureTracker tracker(small_camera(), {}, 1);
  std::set<std::int64_t> ids;
  for (int i = 0; i < 5; ++i) {
    const auto frame = world.frame(i, true);
    const auto seen = tracker.track(frame_at(i), frame.gray, frame.depth, frame.masks);
    for (const auto& f : seen.bodies.at(3)) ids.insert(f.track);
  }
  const auto empty = world.frame(5, false);
  for (int i = 5; i < 10; ++i) tracker.track(frame_at(i), empty.gray, empty.depth, empty.masks);
  world.box = box_cards(3, {0.5, 0.4, 0.3}, 777);
  int old = 0;
  for (int i = 10; i < 13; ++i) {
    const auto frame = world.frame(i, true);
    const auto seen = tracker.track(frame_at(i), frame.gray, frame.depth, frame.masks);
    for (const auto& f : seen.bodies.at(3)) old += ids.contains(f.track);
  }
  EXPECT_EQ(old, 0);
}

}  // namespace
}  // namespace uniquadric
