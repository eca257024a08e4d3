#include <gtest/gtest.h>

#include "tests/evaluation/trajectory_fixture.h"

namespace uniquadric {
namespace {
constexpr double kFitted = 1e-7;  // m or rad, of what the iterated calibration leaves
}

TEST(DriftAngles, AreUnwrappedAndSigned) {
  const std::vector<Pose> still(101, random_walk(1, 7)[0]);
  const auto turning = [&](const Eigen::Vector3d& axis, double angle) {
    return changed(still, [&](std::size_t i, const Pose& p) {
      const double part = static_cast<double>(i) / 100;
      return p * Pose{Eigen::Quaterniond(Eigen::AngleAxisd(angle * part, axis)), Eigen::Vector3d::Zero()};
    });
  };
  const auto z = *drift_angles(pairs_of(still, turning(Eigen::Vector3d::UnitZ(), 400 * kDegree)));
  EXPECT_NEAR(z.yaw.max_rad, 400 * kDegree, kPoseRounding);
  EXPECT_EQ(z.yaw.max_index, 100u);
  EXPECT_NEAR(z.yaw.min_rad, 0, kPoseRounding);
  EXPECT_NEAR(z.roll.max_rad - z.roll.min_rad, 0, kPoseRounding);
  const auto y = *drift_angles(pairs_of(still, turning(Eigen::Vector3d::UnitY(), -150 * kDegree)));
  EXPECT_NEAR(y.pitch.min_rad, -150 * kDegree, 1e-6);  // through the right angle, where the others flip
  EXPECT_EQ(y.pitch.min_index, 100u);
  EXPECT_NEAR(y.yaw.max_rad, 0, 1e-6);
  const auto x = *drift_angles(pairs_of(still, turning(Eigen::Vector3d::UnitX(), -30 * kDegree)));
  EXPECT_NEAR(x.roll.min_rad, -30 * kDegree, kPoseRounding);
  EXPECT_FALSE(drift_angles({}).has_value());
}

TEST(DriftAngles, RollPitchYawAreOfRzRyRx) {
  const Eigen::Matrix3d R =
      (Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(-0.2, Eigen::Vector3d::UnitY()) *
       Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitX()))
          .toRotationMatrix();
  EXPECT_TRUE(roll_pitch_yaw(R).isApprox(Eigen::Vector3d(0.1, -0.2, 0.3), kPoseRounding));
}

TEST(CalibratedDrift, UndoesAnotherFrameOfTheSameBody) {
  RandomStream random(8, "calibration");
  const auto way = random_walk(60, 9);
  const Pose body = {random_rotation(random), random_vector(random, 1)},
             world = {random_rotation(random), {4, 5, 6}};
  const auto other = changed(way, [&](std::size_t, const Pose& p) { return world * p * body; });
  const auto drift = *calibrated_drift(pairs_of(way, other));
  EXPECT_TRUE(drift.determined);
  EXPECT_NEAR(drift.max_translation_m, 0, kFitted);
  EXPECT_NEAR(drift.roll_pitch_yaw_rad.norm(), 0, kFitted);
  const PoseError off = absolute_error(body, drift.reference_from_estimate);
  EXPECT_NEAR(off.translation_m, 0, kFitted);
  EXPECT_NEAR(off.rotation_rad, 0, kFitted);
  EXPECT_GT(maximum_drift(pairs_of(way, other))->max_translation_m,
            0.3);  // the form without calibration does not
}

TEST(CalibratedDrift, FitsAllOfALongWayThoughItStartsFromAPart) {
  const auto way = random_walk(1200, 12);
  RandomStream random(13, "body");
  const Pose body = {random_rotation(random), random_vector(random, 1)};
  auto other = changed(way, [&](std::size_t, const Pose& p) { return p * body; });
  other[700] = other[700] * Pose{yaw(0.3), {0.2, 0, 0}};  // not among every third
  const auto drift = *calibrated_drift(pairs_of(way, other));
  EXPECT_EQ(drift.angle_index, 700u);
  EXPECT_NEAR(drift.roll_pitch_yaw_rad.norm(), 0.3, 0.02);
  EXPECT_NEAR(absolute_error(body, drift.reference_from_estimate).rotation_rad, 0, 0.01);
}

// Of two turns the one by the greater angle counts, though the other's roll, pitch and yaw are greater each.
TEST(CalibratedDrift, TakesTheGreatestAngleNotTheGreatestRollPitchAndYaw) {
  const auto way = random_walk(400, 14);
  auto other = way;
  const Eigen::Quaterniond about_all = yaw(1) * Eigen::AngleAxisd(1, Eigen::Vector3d::UnitY()) *
                                       Eigen::AngleAxisd(1, Eigen::Vector3d::UnitX());  // by 1.33 rad
  other[150] = other[150] * Pose{about_all, {0, 0, 0}};
  other[250] = other[250] * Pose{yaw(1.5), {0, 0, 0}};
  const auto drift = *calibrated_drift(pairs_of(way, other));
  EXPECT_EQ(drift.angle_index, 250u);
  EXPECT_NEAR(drift.max_angle_rad, 1.5, 0.02);
  const Eigen::Vector3d& angles = drift.roll_pitch_yaw_rad;
  const Eigen::Matrix3d turn = (yaw(angles.z()) * Eigen::AngleAxisd(angles.y(), Eigen::Vector3d::UnitY()) *
                                Eigen::AngleAxisd(angles.x(), Eigen::Vector3d::UnitX()))
                                   .toRotationMatrix();
  EXPECT_NEAR(rotation_angle(turn), drift.max_angle_rad, kPoseRounding);
}

TEST(CalibratedDrift, SaysWhatTheMotionLeavesOpen) {
  const auto flat = spiral(40);  // turns about z alone: C's z is free
  const Pose body = {yaw(0.7), {0.3, -0.2, 0.5}};
  const auto drift =
      *calibrated_drift(pairs_of(flat, changed(flat, [&](std::size_t, const Pose& p) { return p * body; })));
  EXPECT_FALSE(drift.determined);
  EXPECT_NEAR(drift.max_translation_m, 0, kFitted);
}

TEST(CalibratedDrift, IsALeastSquaresFitAndFindsALateJump) {
  RandomStream random(10, "jump");
  const auto way = random_walk(60, 11);
  const auto noisy = changed(way, [&](std::size_t, const Pose& p) {
    return p * Pose{exp_so3(random_vector(random, 0.01)), random_vector(random, 0.01)};
  });
  const auto pairs = pairs_of(way, noisy);
  const auto cost = [&](const Pose& C) {
    double sum = 0;
    for (std::size_t k = 1; k < way.size(); ++k) {
      const Eigen::Matrix4d e = noisy[k].matrix().inverse() * noisy[0].matrix();
      const Eigen::Matrix4d g = way[k].matrix().inverse() * way[0].matrix();
      const Eigen::Matrix4d E = C.matrix() * e * C.matrix().inverse() * g.inverse();
      sum += log_se3({Eigen::Quaterniond(Eigen::Matrix3d(E.topLeftCorner<3, 3>())), E.block<3, 1>(0, 3)})
                 .squaredNorm();
    }
    return sum;
  };
  const Pose best = calibrated_drift(pairs)->reference_from_estimate;
  for (int i = 0; i < 6; ++i)
    for (const double step : {-1e-3, 1e-3}) {
      Vector6d twist = Vector6d::Zero();
      twist[i] = step;
      EXPECT_GT(cost(exp_se3(twist) * best), cost(best)) << i;
    }
  auto jumped = way;
  jumped.back() = jumped.back() * Pose{yaw(0.2), {0.3, 0, 0}};
  const auto drift = *calibrated_drift(pairs_of(way, jumped));
  EXPECT_EQ(drift.translation_index, way.size() - 1);
  EXPECT_EQ(drift.angle_index, way.size() - 1);
  EXPECT_NEAR(drift.max_translation_m, 0.3, 0.05);
  EXPECT_NEAR(drift.roll_pitch_yaw_rad.norm(), 0.2, 0.05);
  EXPECT_FALSE(calibrated_drift(pairs_of({way[0], way[1]}, {way[0], way[1]})).has_value());
}

}  // namespace uniquadric
