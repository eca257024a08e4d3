#include <gtest/gtest.h>

#include "tests/evaluation/trajectory_fixture.h"

namespace uniquadric {

TEST_F(CompareTrajectories, ScaledTrajectory) {
  const auto circle = spiral(63);  // not quite closed: its mean is off the origin
  const auto half = changed(circle, [](std::size_t, const Pose& p) {
    return Pose{p.rotation, 0.5 * p.translation};
  });
  EXPECT_NEAR(ape_m(compare(circle, half)), 1, kPoseRounding);
  for (const auto kind : {AlignmentKind::sim3, AlignmentKind::scale}) {
    const auto c = compare(circle, half, aligned(kind));
    EXPECT_NEAR(ape_m(c), 0, kPoseRounding);
    EXPECT_NEAR(c.alignment.scale, 2, kPoseRounding);
    EXPECT_NEAR(c.estimate_path_m, c.reference_path_m / 2, kPoseRounding);  // inputs are not changed
  }
  const auto rigid = compare(circle, half, aligned(AlignmentKind::se3));
  EXPECT_NEAR(ape_m(rigid), 1, 0.01);
  EXPECT_EQ(rigid.alignment.scale, 1);
}

TEST_F(CompareTrajectories, YawAlignmentLeavesATilt) {
  const auto way = random_walk(50, 1);
  const Pose turn = {yaw(1.3), {5, -2, 1}};
  const Pose tilt = {Eigen::Quaterniond(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitX())),
                     Eigen::Vector3d::Zero()};
  const auto by = [](const Pose& move) { return [move](std::size_t, const Pose& p) { return move * p; }; };
  EXPECT_NEAR(ape_m(compare(way, changed(way, by(turn)), aligned(AlignmentKind::posyaw))), 0, kPoseRounding);
  const auto tilted = compare(way, changed(way, by(tilt * turn)), aligned(AlignmentKind::posyaw));
  EXPECT_GT(ape_m(tilted), 0.01);
  EXPECT_NEAR(figure(tilted, PoseRelation::ape, ErrorPart::rotation).rmse, 0.1, 0.02);
  EXPECT_NEAR(ape_m(compare(way, changed(way, by(tilt * turn)), aligned(AlignmentKind::se3))), 0,
              kPoseRounding);
}

TEST_F(CompareTrajectories, WhereTheEstimatesWorldLiesDoesNotMatterAfterAlignment) {
  RandomStream random(3, "worlds");
  const auto way = random_walk(60, 4);
  const auto noisy = changed(way, [&](std::size_t, const Pose& p) {
    return p * Pose{exp_so3(random_vector(random, 0.02)), random_vector(random, 0.05)};
  });
  const Pose move = {random_rotation(random), {30, -20, 10}};
  const auto elsewhere = changed(noisy, [&](std::size_t, const Pose& p) { return move * p; });
  for (const auto kind : {AlignmentKind::first, AlignmentKind::se3, AlignmentKind::sim3}) {
    const auto a = compare(way, noisy, aligned(kind)), b = compare(way, elsewhere, aligned(kind));
    EXPECT_GT(ape_m(a), 0.01);
    for (std::size_t i = 0; i < a.errors.size(); ++i)
      EXPECT_NEAR(statistics(a.errors[i].values)->rmse, statistics(b.errors[i].values)->rmse, kPoseRounding);
  }
  EXPECT_GT(ape_m(compare(way, elsewhere)), 1);
  EXPECT_NEAR(rpe_m(compare(way, elsewhere)), rpe_m(compare(way, noisy)), kPoseRounding);
}

TEST_F(CompareTrajectories, AlignsByTheFirstPairsAlone) {
  const auto way = spiral(60, 0.01);
  const auto late = changed(way, [](std::size_t i, const Pose& p) {
    return i < 30 ? p : Pose{p.rotation, p.translation + Eigen::Vector3d(0, 0, 1)};
  });
  TrajectoryOptions options = aligned(AlignmentKind::se3);
  options.align_pairs = 30;
  const auto c = compare(way, late, options);
  EXPECT_EQ(c.aligned_pairs, 30u);
  EXPECT_NEAR(ape_m(c), std::sqrt(0.5), kPoseRounding);
  EXPECT_LT(ape_m(compare(way, late, aligned(AlignmentKind::se3))), 0.6);
  options.align_pairs = 1000;
  EXPECT_EQ(compare(way, late, options).aligned_pairs, 60u);
}

}  // namespace uniquadric
