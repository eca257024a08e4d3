// Tests of plausibility by closed forms: made motions, of which one thing is wrong.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <functional>
#include <numbers>
#include <set>

#include "estimator/plausibility/axis_turns.h"
#include "estimator/plausibility/imu_turns.h"
#include "estimator/plausibility/pose_lookup.h"
#include "estimator/plausibility/self_calibration.h"

namespace uniquadric {
namespace {

constexpr std::int64_t kStep_ns = 5'000'000;

TEST(AxisTurns, AreAll48AndTheProperOnesAre24Rotations) {
  std::set<std::string> names;
  for (const AxisTurn& turn : axis_turns()) {
    names.insert(turn.name);
    EXPECT_TRUE((turn.matrix * turn.matrix.transpose()).isIdentity());
  }
  EXPECT_EQ(names.size(), 48u);
  EXPECT_TRUE(axis_turns().front().matrix.isIdentity());
  EXPECT_EQ(proper_axis_turns().size(), 24u);
  for (const AxisTurn& turn : proper_axis_turns()) EXPECT_DOUBLE_EQ(turn.matrix.determinant(), 1);
}

TEST(PoseNear, LiesBetweenNeighboursAndNowhereElse) {
  Pose moved;
  moved.translation.x() = 1;
  const Trajectory trajectory{{0, Pose()}, {100'000'000, moved}, {2'000'000'000, moved}};
  EXPECT_NEAR(pose_near(trajectory, 25'000'000)->translation.x(), 0.25, 1e-12);
  EXPECT_EQ(pose_near(trajectory, -500'000)->translation.x(), 0);
  EXPECT_FALSE(pose_near(trajectory, -2'000'000));
  EXPECT_FALSE(pose_near(trajectory, 1'000'000'000));  // its neighbours are too far apart
  EXPECT_FALSE(pose_near(trajectory, 2'100'000'000));
}

// A rate whose axis wanders, so that no other axes, time or sign fit.
Eigen::Vector3d rate_at(double time_s) {
  return {0.8 * std::sin(3 * time_s), 0.5 * std::cos(2 * time_s), 0.3 * std::sin(5 * time_s + 1)};
}

std::vector<ImuSample> readings() {
  std::vector<ImuSample> samples;
  for (std::int64_t ns = -1'000'000'000; ns <= 3'000'000'000; ns += kStep_ns)
    samples.push_back({ns, rate_at(1e-9 * static_cast<double>(ns)), Eigen::Vector3d(0, 0, 9.81)});
  return samples;
}

std::vector<Turn> turns_of_camera() {
  std::vector<Turn> turns;
  for (std::int64_t ns = 0; ns < 2'000'000'000; ns += 200'000'000)
    turns.push_back({ns, ns + 250'000'000, Eigen::Vector3d::Zero()});
  const auto exact = turns_by(readings(), turns, 0);
  for (std::size_t i = 0; i < turns.size(); ++i) turns[i].vector = *exact[i];
  return turns;
}

std::string suspicion(const std::function<void(ImuSample&)>& change) {
  std::vector<ImuSample> samples = readings();
  for (ImuSample& sample : samples) change(sample);
  return gyroscope_suspicion({}, samples, turns_of_camera()).value_or("");
}

TEST(GyroscopeSuspicion, NamesAxesUnitAndTime) {
  EXPECT_EQ(suspicion([](ImuSample&) {}), "");
  EXPECT_TRUE(suspicion([](ImuSample& s) {
                std::swap(s.angular_velocity_radps.x(), s.angular_velocity_radps.y());
              }).starts_with("the gyroscope's x y z look like y x z"));
  EXPECT_TRUE(suspicion([](ImuSample& s) {
                s.angular_velocity_radps *= 180 / std::numbers::pi;
              }).starts_with("angular velocities look like deg/s: "));
  EXPECT_TRUE(suspicion([](ImuSample& s) {
                s.stamp_ns += 150'000'000;
              }).starts_with("its stamps look late by 0.15 s"));
}

TEST(GyroscopeSuspicion, SaysNothingOfACameraAtRest) {
  std::vector<Turn> turns = turns_of_camera();
  for (Turn& turn : turns) turn.vector *= 0.001;
  EXPECT_FALSE(gyroscope_suspicion({}, readings(), turns));
}

// Points in a box before the camera, exactly seen from two places, with depths of a camera `truth`.
FramePair pair_of(const Camera& truth, const Pose& b_from_a, std::uint64_t seed) {
  FramePair pair;
  pair.b_from_a = b_from_a;
  for (int i = 0; i < 80; ++i) {
    const auto at = [&](int k) {
      return std::fmod(0.618034 * (i + 1) * (k + 1) + 0.37 * static_cast<double>(seed), 1.0);
    };
    const Eigen::Vector3d a(2 * at(0) - 1, 1.5 * at(1) - 0.75, 1.5 + 2 * at(2)), b = b_from_a * a;
    PointPair& point = pair.points.emplace_back();
    point.a = *truth.project(a);
    point.b = *truth.project(b);
    point.depth_a_m = a.z(), point.depth_b_m = b.z();
    point.sigma_a_m = point.sigma_b_m = 0.001;
  }
  return pair;
}

TEST(SelfCalibrate, FindsTheIntrinsicsThatPointsMoveRigidlyWith) {
  const Camera truth;
  Camera stated = truth;
  stated.fx *= 1.15, stated.fy *= 1.15, stated.cx += 12;
  std::vector<FramePair> pairs;
  for (int i = 0; i < 6; ++i) {
    Vector6d xi;
    xi << 0.1 * std::sin(i), 0.05, 0.08 * std::cos(i), 0.1 * std::cos(2 * i), 0.12 * std::sin(i + 1), 0.05;
    pairs.push_back(pair_of(truth, exp_se3(xi), i));
  }
  std::vector<const FramePair*> all;
  for (const FramePair& pair : pairs) all.push_back(&pair);
  const auto fit = self_calibrate(stated, all);
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->log_fx, -std::log(1.15), 0.005);
  EXPECT_NEAR(fit->log_fy, -std::log(1.15), 0.005);
  EXPECT_NEAR(fit->cx_px, -12, 1);
  EXPECT_NEAR(fit->cy_px, 0, 1);
}

}  // namespace
}  // namespace uniquadric
