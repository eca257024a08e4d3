#include "simulator/scene/carried_motions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "simulator/scene/spline.h"

namespace uniquadric {
namespace {

using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;

// Velocity, acceleration and angular velocity against central differences of the poses.
void expect_consistent(const Motion& motion, double time_s, double tolerance) {
  constexpr double h = 1e-4;
  const Pose before = motion.at(time_s - h), here = motion.at(time_s), after = motion.at(time_s + h);
  const Kinematics kinematics = motion.kinematics(time_s);
  EXPECT_LT(((after.translation - before.translation) / (2 * h) - kinematics.velocity_mps).norm(), tolerance);
  EXPECT_LT(((after.translation - 2 * here.translation + before.translation) / (h * h) -
             kinematics.acceleration_mps2)
                .norm(),
            1e3 * tolerance);
  const Vector3d turn = log_so3(before.rotation.conjugate() * after.rotation) / (2 * h);
  EXPECT_LT((turn - kinematics.angular_velocity_radps).norm(), tolerance);
}

TEST(Tremor, HasItsRootMeanSquareOnEachAxis) {
  const Motion motion = tremor_motion({0.002, 0.01, 5});
  Vector3d position = Vector3d::Zero(), turn = Vector3d::Zero();
  constexpr int kCount = 20000;
  for (int i = 0; i < kCount; ++i) {  // 1000 s: many periods of every wave
    const Pose pose = motion.at(0.05 * i);
    position += pose.translation.cwiseAbs2() / kCount;
    turn += log_so3(pose.rotation).cwiseAbs2() / kCount;
  }
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(std::sqrt(position[k]) / 0.002, 1, 0.02) << k;
    EXPECT_NEAR(std::sqrt(turn[k]) / 0.01, 1, 0.03) << k;  // turns about three axes mix a little
  }
}

TEST(Tremor, DerivativesAreThoseOfThePose) {
  const Motion motion = tremor_motion({0.002, 0.01, 5});
  for (const double time_s : {0.0, 0.37, 4.2}) expect_consistent(motion, time_s, 1e-5);
  EXPECT_FALSE(motion.at(1).translation.isApprox(tremor_motion({0.002, 0.01, 6}).at(1).translation));
}

DriveOptions turning_car() {
  DriveOptions options;
  options.start_m = {3, -2};
  options.heading_rad = 0.4;
  options.speed_mps = 8;
  options.height_m = 0.7;
  options.ahead_m = 0;
  options.legs = {{2, 1.5, 0.2}, {3, -4, 0}, {1, 0, -0.3}};
  return options;
}

TEST(Drive, SteersAlongACircleOfItsWheelbase) {
  DriveOptions options = turning_car();
  options.legs = {{100, 0, 0.2}};
  const Motion motion = drive_motion(options);
  const double radius_m = options.wheelbase_m / std::tan(0.2);
  const Vector3d centre = motion.at(0).translation + motion.at(0).rotation * Vector3d(0, radius_m, 0);
  const double period_s = 2 * kPi * radius_m / 8;
  for (const double time_s : {0.5, 2.0, 7.0})
    EXPECT_NEAR((motion.at(time_s).translation - centre).norm(), radius_m, 1e-9);
  EXPECT_LT((motion.at(period_s).translation - motion.at(0).translation).norm(), 1e-9);
  EXPECT_LT(log_so3(motion.at(0).rotation.conjugate() * motion.at(period_s / 4).rotation).z() - kPi / 2,
            1e-9);
}

// An accelerometer shows all that changes the velocity, also ahead of the axle, where steering moves it
// aside.
TEST(Drive, LegsJoinWithoutABlow) {
  DriveOptions options = turning_car();
  options.ahead_m = 2;
  const Motion motion = drive_motion(options);
  for (const double time_s : {0.0, 2.0, 2.3, 5.0, 5.3, 6.0}) {
    const Kinematics before = motion.kinematics(time_s - 1e-9), after = motion.kinematics(time_s + 1e-9);
    EXPECT_LT((after.pose.translation - before.pose.translation).norm(), 1e-7);
    EXPECT_LT((after.velocity_mps - before.velocity_mps).norm(), 1e-6) << time_s;
  }
  options.steering_s = 0;  // the wheels jump: so does what is ahead of the axle
  const Motion jumps = drive_motion(options);
  EXPECT_GT((jumps.kinematics(2 + 1e-9).velocity_mps - jumps.kinematics(2 - 1e-9).velocity_mps).norm(), 1);
}

// Along the way in which it steers the curvature is the mean of both legs'.
TEST(Drive, SteersEvenlyAlongItsWay) {
  DriveOptions options = turning_car();
  options.legs = {{1, 0, 0.2}, {2, 0, -0.3}};
  options.steering_s = 0.5;
  const Motion motion = drive_motion(options);
  const double way_m = 8 * 0.5, from_pm = std::tan(0.2) / 2.7, to_pm = std::tan(-0.3) / 2.7;
  const auto turned = [&](double time_s) {
    return log_so3(motion.at(1).rotation.conjugate() * motion.at(time_s).rotation).z();
  };
  EXPECT_NEAR(turned(1.5), way_m * (from_pm + to_pm) / 2, 1e-12);
  EXPECT_NEAR(turned(1.25), way_m / 2 * (3 * from_pm + to_pm) / 4, 1e-12);
  EXPECT_NEAR(turned(2), way_m * (from_pm + to_pm) / 2 + 4 * to_pm, 1e-12);
}

TEST(Drive, BrakingEndsAtRest) {
  const Motion motion = drive_motion(turning_car());
  EXPECT_NEAR(motion.kinematics(2 - 1e-9).velocity_mps.norm(), 11, 1e-6);
  // 11 m/s are braked away after 2.75 s
  const Pose rest = motion.at(4.75);
  for (const double time_s : {4.9, 5.5, 50.0}) {
    EXPECT_LT((motion.at(time_s).translation - rest.translation).norm(), 1e-9);
    EXPECT_LT(motion.kinematics(time_s).velocity_mps.norm(), 1e-9);
  }
  EXPECT_NEAR(motion.kinematics(-3).velocity_mps.norm(), 8, 1e-9);
  EXPECT_EQ(rest.translation.z(), 0.7);
}

TEST(Drive, DerivativesAreThoseOfThePose) {
  DriveOptions options = turning_car();
  options.ahead_m = 1.3;
  for (const bool optical : {false, true}) {
    options.optical = optical;
    const Motion motion = drive_motion(options);
    for (const double time_s : {-1.0, 1.0, 2.1, 2.25, 3.0}) expect_consistent(motion, time_s, 1e-5);
  }
  const Pose pose = drive_motion(options).at(1);  // a camera looks where it drives
  EXPECT_GT((pose.rotation * Vector3d::UnitZ()).dot(drive_motion(options).kinematics(1).velocity_mps), 0);
}

// On a straight line at constant speed, and on a parabola but for a constant, the curve is the record.
TEST(Recorded, KeepsStraightMotionsAndIsSmooth) {
  std::vector<Waypoint> record;
  for (int i = 0; i <= 40; ++i) {
    const double time_s = 0.1 * i;
    record.push_back({time_s, {exp_so3({0, 0, 0.5 * time_s}), {2 * time_s, 1 - time_s * time_s, 3}}});
  }
  const Motion motion = recorded_motion(record);
  for (const double time_s : {0.7, 1.234, 3.0}) {
    const Kinematics here = motion.kinematics(time_s);
    EXPECT_NEAR(here.pose.translation.x(), 2 * time_s, 1e-9);
    EXPECT_NEAR(here.pose.translation.y(), 1 - time_s * time_s - 0.1 * 0.1 / 3, 1e-9);
    EXPECT_LT((here.angular_velocity_radps - Vector3d(0, 0, 0.5)).norm(), 1e-9);
    EXPECT_LT((here.acceleration_mps2 - Vector3d(0, -2, 0)).norm(), 1e-8);
    expect_consistent(motion, time_s, 1e-5);
  }
  EXPECT_EQ(motion.at(-1).translation, motion.at(0).translation);
  EXPECT_EQ(motion.at(9).translation, motion.at(4).translation);
}

}  // namespace
}  // namespace uniquadric
