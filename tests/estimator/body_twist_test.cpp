#include "estimator/lidar/body_twist.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/random.h"

namespace uniquadric {
namespace {

// A box of 4 x 2 x 1.5 m that moves at a constant screw, 15 m in front of a camera at the world's origin
// whose axes are the world's; its front, left side and roof are seen.
const Eigen::Vector3d kMiddle(1, 0.5, 15), kHalf(1, 0.75, 2);
constexpr double kStep_s = 1.0 / 30;

BodyTwist true_twist(const Eigen::Vector3d& velocity, const Eigen::Vector3d& turn) {
  BodyTwist twist;
  twist.middle = kMiddle;
  twist.rate << velocity, turn;
  return twist;
}

// Where the body's points are now.
std::vector<Eigen::Vector3d> points_now(int count, std::uint64_t seed) {
  RandomStream random(seed, "box");
  const Eigen::Quaterniond turned(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitY()));
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < count; ++i) {
    Eigen::Vector3d p(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    p[i % 3] = -1;
    points.push_back(kMiddle + turned * kHalf.cwiseProduct(p));
  }
  return points;
}

std::vector<AgedPoint> aged(const BodyTwist& truth, double sigma_m, double oldest_s) {
  RandomStream random(7, "ages");
  std::vector<AgedPoint> points;
  for (const Eigen::Vector3d& now : points_now(600, 1)) {
    const double age_s = random.uniform(0, oldest_s);
    const Eigen::Vector3d seen = moved_over(truth, -age_s) * now;
    points.push_back({seen * (1 + sigma_m * random.normal() / seen.norm()), age_s});
  }
  return points;
}

std::vector<PointStep> steps(const BodyTwist& truth, double sigma_px) {
  RandomStream random(8, "pixels");
  std::vector<PointStep> result;
  for (const Eigen::Vector3d& now : points_now(60, 2)) {
    const Eigen::Vector2d noise(random.normal(), random.normal());
    result.push_back({now, *Camera().project(moved_over(truth, -kStep_s) * now) + sigma_px * noise});
  }
  return result;
}

double speed_error(const BodyTwist& twist, const BodyTwist& truth) {
  const auto step = [](const BodyTwist& t) { return moved_over(t, kStep_s) * kMiddle; };
  return (step(twist) - step(truth)).norm() / kStep_s;
}

TEST(BodyTwist, IsAScrewAboutItsMiddle) {
  const BodyTwist twist = true_twist({3, 0, 0}, {0, 0, 2});
  const Eigen::Vector3d side(0, 1, 0);
  const double dt = 1e-6;
  EXPECT_LT(((moved_over(twist, dt) * kMiddle - kMiddle) / dt - Eigen::Vector3d(3, 0, 0)).norm(), 1e-4);
  EXPECT_LT(
      ((moved_over(twist, dt) * (kMiddle + side) - kMiddle - side) / dt - Eigen::Vector3d(1, 0, 0)).norm(),
      1e-4);
  const Pose twice = moved_over(twist, 0.1) * moved_over(twist, 0.1);
  EXPECT_LT((twice.matrix() - moved_over(twist, 0.2).matrix()).norm(), 1e-12);
}

TEST(BodyTwist, PredictedItIsTheSameScrew) {
  BodyTwist later = true_twist({3, 0, 1}, {0, 1, 2});
  predict(later, 0.1, {});
  const BodyTwist now = true_twist({3, 0, 1}, {0, 1, 2});
  EXPECT_LT((moved_over(later, 0.3).matrix() - moved_over(now, 0.3).matrix()).norm(), 1e-12);
  EXPECT_GT(later.covariance.diagonal().minCoeff(), now.covariance.diagonal().maxCoeff());
}

TEST(BodyTwist, PointsOfThreeFacesTellTheWholeMotion) {
  const BodyTwist truth = true_twist({2, 0.2, -10}, {0.05, 0.6, 0});
  BodyTwist twist = unknown_twist(kMiddle, {});
  const auto points = aged(truth, 0, 0.1);
  for (int i = 0; i < 4; ++i) update_by_points(twist, points, Pose(), Camera(), {});
  EXPECT_LT(speed_error(twist, truth), 0.15);  // of 10.2 m/s; the box's edges are no planes
}

TEST(BodyTwist, NoisyPointsTellTheSpeedAlongTheLineOfSight) {
  const BodyTwist truth = true_twist({0, 0, -10}, Eigen::Vector3d::Zero());
  BodyTwist twist = unknown_twist(kMiddle, {});
  for (int i = 0; i < 5; ++i)  // each starts nearer to the truth
    update_by_points(twist, aged(truth, 0.02, 0.1), Pose(), Camera(), {});
  EXPECT_NEAR(twist.rate.z(), -10, 0.4);  // the planes' own noise takes some of the speed
  EXPECT_LT(twist.covariance(2, 2), 1);
}

TEST(BodyTwist, PixelsTellTheMotionAcross) {
  const BodyTwist truth = true_twist({8, -1, 0}, {0, 0, 0.4});
  BodyTwist twist = unknown_twist(kMiddle, {});
  update_by_pixels(twist, steps(truth, 0.2), Pose(), kStep_s, Camera(), {});
  EXPECT_NEAR(twist.rate.x(), 8, 0.2);  // 0.2 px of 60 points are 1 mm at 15 m, over a frame
  EXPECT_NEAR(twist.rate.y(), -1, 0.2);
  EXPECT_NEAR(twist.rate[5], 0.4, 0.1);
}

TEST(BodyTwist, APlaneThatMovesInItselfIsToldByPixels) {
  RandomStream random(9, "board");
  const BodyTwist truth = true_twist({10, 0, 0}, Eigen::Vector3d::Zero());
  std::vector<AgedPoint> points;
  for (int i = 0; i < 500; ++i) {
    const double age_s = random.uniform(0, 0.1);
    const Eigen::Vector3d now(random.uniform(-1, 1), random.uniform(-1, 1), 15);
    points.push_back({moved_over(truth, -age_s) * now, age_s});
  }
  BodyTwist twist = unknown_twist(kMiddle, {});
  update_by_points(twist, points, Pose(), Camera(), {});
  EXPECT_NEAR(twist.rate.z(), 0, 0.01);
  EXPECT_GT(twist.covariance(0, 0), 50);  // nothing is known of it
  update_by_pixels(twist, steps(truth, 0.2), Pose(), kStep_s, Camera(), {});
  EXPECT_NEAR(twist.rate.x(), 10, 0.2);
}

TEST(BodyTwist, FalseTracksCountLittle) {
  const BodyTwist truth = true_twist({8, 0, 0}, Eigen::Vector3d::Zero());
  auto sightings = steps(truth, 0.1);
  for (std::size_t i = 0; i < sightings.size(); i += 5) sightings[i].last_pixel.x() += 15;
  BodyTwist twist = unknown_twist(kMiddle, {});
  update_by_pixels(twist, sightings, Pose(), kStep_s, Camera(), {});
  EXPECT_NEAR(twist.rate.x(), 8, 0.3);
}

TEST(BodyTwist, TooFewPointsTellNothing) {
  BodyTwist twist = unknown_twist(kMiddle, {});
  const Vector6d rate = twist.rate;
  update_by_points(twist, {{kMiddle, 0}, {kMiddle, 0.1}}, Pose(), Camera(), {});
  update_by_points(twist, {}, Pose(), Camera(), {});
  EXPECT_EQ(twist.rate, rate);
}

}  // namespace
}  // namespace uniquadric
