#include "estimator/features/rolling_shutter.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/random.h"
#include "drawn_world.h"
#include "estimator/ego/rgbd_odometry.h"
#include "estimator/features/features.h"

namespace uniquadric {
namespace {

constexpr double kReadout_s = 0.02, kRate_hz = 30;

const Vector6d kTwist = (Vector6d() << 0.3, -0.4, 0.2, 0.7, -0.9, 1.1).finished();

// Where a point is at the time at which row `v` is exposed.
Eigen::Vector3d at_row(const Camera& camera, double v, const Vector6d& twist, const Eigen::Vector3d& point) {
  return exp_se3(kReadout_s * ((v + 0.5) / camera.height - 0.5) * twist) * point;
}

TEST(RollingShutter, APointThatShiftsAlongARowIsMovedBySpeedTimesDelayOverDepth) {
  const Camera camera = small_camera();
  const RollingShutter shutter(camera, kReadout_s);
  Vector6d twist = Vector6d::Zero();
  twist[0] = 1.5;
  for (const double v : {0.0, 60.0, 119.5, 239.0}) {
    const double delay_s = kReadout_s * ((v + 0.5) / 240 - 0.5);
    EXPECT_NEAR(shutter.delay_s(v), delay_s, 1e-15);
    const auto place = shutter.at_stamp({100, v}, 2, twist);
    ASSERT_TRUE(place);
    EXPECT_NEAR(place->x(), 100 - camera.fx * 1.5 * delay_s / 2, 1e-6);
    EXPECT_NEAR(place->y(), v, 1e-9);
  }
  EXPECT_NEAR((*shutter.at_stamp({100, 119.5}, 2, kTwist) - Eigen::Vector2d(100, 119.5)).norm(), 0, 1e-12);
}

TEST(RollingShutter, WhatARowSeesIsMovedToThePointsProjectionAtTheStamp) {
  Camera camera = small_camera();
  for (const bool is_distorted : {false, true}) {
    if (is_distorted) camera.distortion = {-0.1, 0.02, 0.001, -0.001, 0};
    const RollingShutter shutter(camera, kReadout_s);
    for (const double x : {-0.8, 0.1, 0.9})
      for (const double y : {-0.7, 0.2, 0.6}) {
        const Eigen::Vector3d point(x, y, 2);
        const auto seen = shutter.seen_at(point, kTwist);
        ASSERT_TRUE(seen);
        const auto by_row = camera.project(at_row(camera, seen->y(), kTwist, point));
        EXPECT_NEAR((*seen - *by_row).norm(), 0, 1e-3);  // the row that sees it is the row it is on
        const auto place = shutter.at_stamp(*by_row, 2, kTwist);
        ASSERT_TRUE(place);
        EXPECT_NEAR((*place - *camera.project(point)).norm(), 0, 1e-3);
        EXPECT_GT((*place - *by_row).norm(), 0.05);
      }
  }
}

TEST(RollingShutter, WithoutReadOutTimeNothingIsMoved) {
  const Camera camera = small_camera();
  const RollingShutter shutter(camera, 0);
  const Eigen::Vector2d pixel(17.3, 201.9);
  EXPECT_EQ(*shutter.at_stamp(pixel, 1.7, kTwist), pixel);
  EXPECT_EQ(*shutter.seen_at({0.3, 0.2, 1.7}, kTwist), *camera.project({0.3, 0.2, 1.7}));
}

struct Rows {
  std::vector<PointSighting> sightings;
  std::vector<double> delays_s;
};

// Points of a body as the rows saw them, moved to the stamp by `presumed`.
Rows seen_rows(const Camera& camera, const Pose& camera_from_body, const Vector6d& presumed, int count) {
  const RollingShutter shutter(camera, kReadout_s);
  RandomStream random(3, "rows");
  Rows rows;
  while (std::ssize(rows.sightings) < count) {
    const Eigen::Vector3d point(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-0.5, 0.5));
    const Eigen::Vector3d at_stamp = camera_from_body * point;
    const auto seen = shutter.seen_at(at_stamp, kTwist);
    if (!seen || !camera.contains(*seen)) continue;
    const auto place = shutter.at_stamp(*seen, at_stamp.z(), presumed);
    rows.sightings.push_back({point, *place, at_stamp.z(), 1e-3});
    rows.delays_s.push_back(shutter.delay_s(seen->y()));
  }
  return rows;
}

TEST(RollingShutter, RowsTellPoseAndTwist) {
  const Camera camera = small_camera();
  const Pose truth{exp_so3({0.3, -0.5, 0.2}), {0.1, -0.05, 2}};
  const Vector6d presumed = 0.6 * kTwist;
  const Rows rows = seen_rows(camera, truth, presumed, 200);
  const Pose start = exp_se3((Vector6d() << 0.01, 0, -0.01, 0.005, 0.005, 0).finished()) * truth;
  RollingShutterOptions open;
  open.velocity_sigma_mps = open.turn_sigma_radps = 100;
  const auto fit =
      fit_moving_pose(rows.sightings, rows.delays_s, camera, {start, presumed}, presumed, 0.1, open);
  ASSERT_TRUE(fit);
  EXPECT_LT((fit->twist - kTwist).norm(), 0.02 * kTwist.norm());  // linear in the change of the twist
  EXPECT_LT(log_se3(fit->camera_from_body * truth.inverse()).norm(), 5e-4);
}

TEST(RollingShutter, FewSightingsLeaveTheTwistWhereItIsExpected) {
  const Camera camera = small_camera();
  const Pose truth{Eigen::Quaterniond::Identity(), {0, 0, 2}};
  Rows rows = seen_rows(camera, truth, kTwist, 4);
  for (auto& s : rows.sightings) s.pixel += Eigen::Vector2d(0.1, -0.1);
  const auto fit = fit_moving_pose(rows.sightings, rows.delays_s, camera, {truth, kTwist}, kTwist, 0.12, {});
  ASSERT_TRUE(fit);
  EXPECT_LT((fit->twist - kTwist).norm(), 0.05);
}

// A camera in a hand that sways before two walls, read out in bands of rows.
struct HandHeld {
  Pose world_from_camera(double time_s) const {
    const auto sway = [&](double hertz, double phase) { return std::sin(2 * M_PI * hertz * time_s + phase); };
    return {exp_so3({0.02 * sway(2.5, 0), 0.03 * sway(1.9, 1), 0.02 * sway(3.1, 2)}),
            {0.3 * time_s, 0.01 * sway(2.2, 1), 0.01 * sway(1.7, 2)}};
  }
  DrawnFrame at(double time_s, std::uint64_t frame) const {
    std::vector<DrawnCard> cards;
    const Pose camera_from_world = world_from_camera(time_s).inverse();
    for (int side : {-1, 1}) {
      cards.push_back({0, {4, 5}, textures[side > 0], {}});
      cards.back().camera_from_card =
          camera_from_world * Pose{exp_so3({0, 0.5 * side, 0}), {1.6 * side, 0, 2.6}};
    }
    return draw(small_camera(), cards, {0.003, 1}, frame);
  }
  DrawnFrame frame(int i) const {
    constexpr int kBands = 8;
    const Camera camera = small_camera();
    DrawnFrame result = at(i / kRate_hz, i);
    for (int band = 0; band < kBands; ++band) {
      const cv::Range rows(camera.height * band / kBands, camera.height * (band + 1) / kBands);
      const double delay_s = kReadout_s * ((band + 0.5) / kBands - 0.5);
      at(i / kRate_hz + delay_s, i).gray.rowRange(rows).copyTo(result.gray.rowRange(rows));
    }
    return result;
  }
  std::vector<cv::Mat> textures{block_texture(700, 5), block_texture(700, 6)};
};

// Root mean square of the positions, relative to the second: the first is placed before anything moves.
double position_error_m(const HandHeld& world, const Trajectory& trajectory) {
  const auto truth_at = [&](std::int64_t stamp_ns) {
    return world.world_from_camera(1e-9 * double(stamp_ns));
  };
  double sum = 0;
  for (const auto& [stamp_ns, pose] : trajectory) {
    const Pose truth = relative_pose(truth_at(trajectory[1].stamp_ns), truth_at(stamp_ns));
    sum += (relative_pose(trajectory[1].pose, pose).translation - truth.translation).squaredNorm();
  }
  return std::sqrt(sum / double(trajectory.size()));
}

TEST(RollingShutter, AHandHeldCameraIsFollowedByItsRows) {
  constexpr int kFrames = 16;
  const HandHeld world;
  FeatureOptions off;
  off.rolling_shutter.enabled = false;
  FeatureTracker with(small_camera(), {}, 1, kReadout_s), without(small_camera(), off, 1, kReadout_s);
  RgbdOdometry odometry(small_camera(), {}, 1, 1, kReadout_s), blind(small_camera(), {}, 1);
  for (int i = 0; i < kFrames; ++i) {
    SequenceFrame frame;
    frame.frame = i;
    frame.stamp_ns = std::llround(i * 1e9 / kRate_hz);
    const DrawnFrame drawn = world.frame(i);
    odometry.track(frame, with.track(frame, drawn.gray, drawn.depth, {}), {}, {});
    blind.track(frame, without.track(frame, drawn.gray, drawn.depth, {}), {}, {});
  }
  for (const Trajectory& path : {odometry.trajectory(), odometry.causal_trajectory()}) {
    ASSERT_EQ(std::ssize(path), kFrames);
    const double error_m = position_error_m(world, path);
    EXPECT_LT(error_m, 0.4 * position_error_m(world, blind.trajectory()));
    EXPECT_LT(error_m, 0.003);
  }
}

}  // namespace
}  // namespace uniquadric
