#include <gtest/gtest.h>

#include "tests/evaluation/trajectory_fixture.h"

namespace uniquadric {

TEST(KittiOdometry, StraightWayLongerByTwoPercentThatBends) {
  std::vector<Pose> straight, bent;
  for (int i = 0; i <= 1000; ++i) {
    straight.push_back({Eigen::Quaterniond::Identity(), {1.0 * i, 0, 0}});
    bent.push_back({yaw(0.01 * kDegree * i), {1.02 * i, 0, 0}});
  }
  const auto turned = *kitti_odometry(pairs_of(straight, changed(straight, [&](std::size_t i, const Pose& p) {
                                                 return Pose{bent[i].rotation, p.translation};
                                               })));
  const auto longer = *kitti_odometry(pairs_of(straight, changed(bent, [](std::size_t, const Pose& p) {
                                                 return Pose{Eigen::Quaterniond::Identity(), p.translation};
                                               })));
  ASSERT_EQ(longer.lengths.size(), 8u);
  double sum_percent = 0, sum_deg = 0;
  std::size_t parts = 0;
  for (std::size_t n = 1; n <= 8; ++n) {
    const double length = 100.0 * static_cast<double>(n),
                 taken = length + 1;  // ends with the first pose past it
    const KittiErrors &errors = longer.lengths[n - 1].errors, &turns = turned.lengths[n - 1].errors;
    EXPECT_EQ(longer.lengths[n - 1].length_m, length);
    EXPECT_EQ(errors.parts, 100 - 10 * n);  // starts 0, 10, ... up to the last that leaves 100 n + 1 m
    EXPECT_NEAR(errors.translation_percent, 2 * taken / length, kPoseRounding);
    EXPECT_NEAR(errors.rotation_deg_per_100m, 0, kPoseRounding);
    EXPECT_NEAR(turns.rotation_deg_per_100m, taken / length, kPoseRounding);
    parts += errors.parts;
    sum_percent += static_cast<double>(errors.parts) * errors.translation_percent;
    sum_deg += static_cast<double>(turns.parts) * turns.rotation_deg_per_100m;
  }
  EXPECT_EQ(longer.mean.parts, parts);
  EXPECT_NEAR(longer.mean.translation_percent, sum_percent / static_cast<double>(parts), kPoseRounding);
  EXPECT_NEAR(turned.mean.rotation_deg_per_100m, sum_deg / static_cast<double>(parts), kPoseRounding);
  straight.resize(100);
  EXPECT_FALSE(kitti_odometry(pairs_of(straight, straight)).has_value());
}

}  // namespace uniquadric
