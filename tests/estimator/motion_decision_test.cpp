#include "estimator/objects/motion_decision.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/base/random.h"
#include "estimator/objects/body_estimator.h"
#include "synthetic_perception.h"

namespace uniquadric {
namespace {

const Eigen::Vector3d kPlace(0, 0, 1), kAxes(0.3, 0.2, 0.15);

Pose walking_camera(double t) {
  const double angle = -0.6 + 0.1 * t;
  const Eigen::Vector3d from(2.2 * std::sin(angle), -2.2 * std::cos(angle), 1.6);
  const Eigen::Vector3d z = (kPlace - from).normalized(), x = z.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d R;
  R << x, z.cross(x), z;
  return {Eigen::Quaterniond(R), from};
}

Pose standing(double) {
  return {exp_so3({0, 0, 0.4}), kPlace};
}

std::function<Pose(double)> sliding(double from_s, double speed_mps) {
  return [=](double t) {
    Pose pose = standing(t);
    pose.translation.x() += speed_mps * std::max(0.0, t - from_s);
    return pose;
  };
}

Pose swinging(double t) {
  Pose pose = standing(t);
  pose.translation.x() += 0.2 * std::cos(2 * std::numbers::pi * t / 3);
  return pose;
}

struct Watched {
  std::vector<ObjectMotion> motions;  // by frame

  int count(ObjectMotion motion, double from_s, double to_s) const {
    int n = 0;
    for (std::size_t f = 0; f < motions.size(); ++f)
      n +=
          motions[f] == motion && static_cast<double>(f) >= 30 * from_s && static_cast<double>(f) < 30 * to_s;
    return n;
  }
};

// The camera's poses are off by a millimetre and a milliradian, as an odometry's.
Watched watch(const std::function<Pose(double)>& motion) {
  SyntheticOptions options;
  options.frames = 180;
  options.world_from_camera = walking_camera;
  SyntheticPerception perception = synthetic_perception({box_body(kAxes, motion)}, options);
  BodyEstimator estimator(1, perception.camera, {}, 1);
  Watched result;
  for (PerceivedFrame& frame : perception.frames) {
    RandomStream random(3, "camera", frame.frame, 0);
    const auto normals = [&] { return Eigen::Vector3d(random.normal(), random.normal(), random.normal()); };
    *frame.world_from_camera = *frame.world_from_camera * Pose{exp_so3(5e-4 * normals()), 1e-3 * normals()};
    const auto state = estimator.step(frame, &frame.bodies.at(0));
    result.motions.push_back(state ? state->motion : ObjectMotion::unknown);
  }
  return result;
}

TEST(StaticOrDynamic, ABodyThatStandsWhileTheCameraMovesIsStaticAfterASecond) {
  const Watched standing_body = watch(standing);
  EXPECT_EQ(standing_body.count(ObjectMotion::unknown, 0, 0.9), 27);  // no rest is proved so soon
  EXPECT_EQ(standing_body.count(ObjectMotion::at_rest, 1.5, 6), 135);
}

TEST(StaticOrDynamic, OneThatStartsToMoveIsDynamicSoonAfter) {
  const Watched starts = watch(sliding(3, 0.3));
  EXPECT_EQ(starts.count(ObjectMotion::at_rest, 1.5, 3), 45);
  EXPECT_EQ(starts.count(ObjectMotion::moving, 0, 3), 0);
  EXPECT_EQ(starts.count(ObjectMotion::moving, 3.8, 6), 66);
}

TEST(StaticOrDynamic, TwoCentimetresASecondAreNoRest) {
  const Watched slow = watch(sliding(0, 0.02));
  EXPECT_EQ(slow.count(ObjectMotion::at_rest, 0, 6), 0);
  EXPECT_EQ(slow.count(ObjectMotion::moving, 3, 6), 90);
}

TEST(StaticOrDynamic, ASwingIsNeverStaticThoughItStopsAtItsTurns) {
  const Watched swing = watch(swinging);
  EXPECT_EQ(swing.count(ObjectMotion::at_rest, 0, 6), 0);
  EXPECT_EQ(swing.count(ObjectMotion::moving, 1.5, 6), 135);
}

TEST(StaticOrDynamic, OneThatStopsIsStaticAgain) {
  const Watched stops = watch([](double t) { return sliding(0, 0.3)(std::min(t, 2.0)); });
  EXPECT_EQ(stops.count(ObjectMotion::at_rest, 0, 3), 0);
  EXPECT_EQ(stops.count(ObjectMotion::at_rest, 5, 6), 30);
}

// The decision by itself: samples a tenth of a second apart, a millimetre of uncertainty, 2 m away.
struct Samples {
  MotionDecision decision{MotionDecisionOptions{}};
  double t = 0;

  ObjectMotion add(double x_m, double turn_rad = 0) {
    const Matrix6d covariance = 1e-6 * Matrix6d::Identity();
    decision.add(std::llround(1e9 * t), Pose{Eigen::Quaterniond::Identity(), {0, 0, -2}},
                 Pose{exp_so3({0, 0, turn_rad}), {x_m, 0, 0}}, covariance, 0.2);
    t += 0.1;
    return decision.now();
  }
};

TEST(MotionDecision, OneWrongPoseChangesNothing) {
  Samples samples;
  for (int i = 0; i < 20; ++i) samples.add(0);
  EXPECT_EQ(samples.decision.now(), ObjectMotion::at_rest);
  EXPECT_EQ(samples.add(0.3), ObjectMotion::at_rest);
  EXPECT_EQ(samples.add(0), ObjectMotion::at_rest);
  samples.add(0.3);
  EXPECT_EQ(samples.add(0.3), ObjectMotion::moving);
}

TEST(MotionDecision, ABodyThatTurnsInItsPlaceMoves) {
  Samples samples;
  for (int i = 0; i < 20; ++i) samples.add(0, 0.1 * i);
  EXPECT_EQ(samples.decision.now(), ObjectMotion::moving);
}

TEST(MotionDecision, BetweenTheTwoThresholdsTheDecisionStands) {
  const auto settled = [](double far_m) {
    Samples samples;
    for (int i = 0; i < 25; ++i) samples.add(0);
    for (int i = 0; i < 9; ++i) samples.add(far_m);
    return samples.decision.now();
  };
  const double sigma_m = 1e-3 * std::sqrt(2 * (1.0 + 1 + 2 * 2 + 1));  // own, camera's, its turn, surface
  EXPECT_EQ(settled(4.5 * sigma_m), ObjectMotion::at_rest);
  EXPECT_EQ(settled(5.5 * sigma_m), ObjectMotion::moving);
}

TEST(MotionDecision, FewFramesASecondAreComparedFurtherBack) {
  Samples still, moved;
  for (int i = 0; i < 6; ++i) {
    still.add(0);
    moved.add(0.05 * i);
    still.t += 3;
    moved.t += 3;
  }
  EXPECT_EQ(still.decision.now(), ObjectMotion::at_rest);
  EXPECT_EQ(moved.decision.now(), ObjectMotion::moving);
}

TEST(MotionDecision, WhatIsForgottenIsUndecidedForASecond) {
  Samples samples;
  for (int i = 0; i < 20; ++i) samples.add(0);
  samples.decision.forget();
  for (int i = 0; i < 10; ++i) EXPECT_EQ(samples.add(0), ObjectMotion::unknown);
  EXPECT_EQ(samples.add(0), ObjectMotion::at_rest);
}

}  // namespace
}  // namespace uniquadric
