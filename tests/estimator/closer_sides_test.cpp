#include "estimator/objects/closer_sides.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/base/random.h"

namespace uniquadric {
namespace {

const Eigen::Vector3d kHalf(0.3, 0.2, 0.15);
constexpr double kRadius_m = 0.25;

Shape box_turned(double angle_rad, const Eigen::Vector3d& semi_axes_m = kHalf) {
  Shape shape;
  shape.body_from_object = {exp_so3({0, 0, angle_rad}), Eigen::Vector3d(0.4, -0.1, 0.2)};
  shape.semi_axes_m = semi_axes_m;
  return shape;
}

// Of the sides of box_turned(0), `noise_m` off.
Eigen::Matrix3Xd points_of_sides(double noise_m) {
  RandomStream random(1, "points");
  Eigen::Matrix3Xd points(3, 600);
  for (int i = 0; i < points.cols(); ++i) {
    Eigen::Vector3d p(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    p[i % 3] = i % 2 ? 1 : -1;
    p = p.cwiseProduct(kHalf);
    p[i % 3] += noise_m * random.normal();
    points.col(i) = box_turned(0).body_from_object * p;
  }
  return points;
}

bool is_closer(const Shape& other, const Shape& best, double noise_m = 0.003) {
  const Eigen::Matrix3Xd points = points_of_sides(noise_m);
  return has_closer_sides(other, best, {{}, points, kRadius_m, {}});
}

TEST(CloserSides, AreThoseOfTheBoxThatThePointsAreOf) {
  EXPECT_TRUE(is_closer(box_turned(0), box_turned(0.3)));
  EXPECT_FALSE(is_closer(box_turned(0.3), box_turned(0)));
  EXPECT_TRUE(is_closer(box_turned(0.1), box_turned(0.4)));
  EXPECT_TRUE(is_closer(box_turned(0), box_turned(0, kHalf + Eigen::Vector3d::Constant(0.03))));
}

// Which box is asked about has to be better by a tenth: neither of two alike is closer.
TEST(CloserSides, AreNeitherOfTwoAlike) {
  EXPECT_FALSE(is_closer(box_turned(0), box_turned(0)));
  EXPECT_FALSE(is_closer(box_turned(0.3), box_turned(-0.3)));
  EXPECT_FALSE(is_closer(box_turned(-0.3), box_turned(0.3)));
  // half a turn, and other names of the axes, are the same sides
  const Shape box = box_turned(0.2);
  EXPECT_FALSE(is_closer(box_turned(0.2 + std::numbers::pi), box));
  const Shape renamed = box_turned(0.2 + std::numbers::pi / 2, {kHalf.y(), kHalf.x(), kHalf.z()});
  EXPECT_FALSE(is_closer(renamed, box) || is_closer(box, renamed));
}

TEST(CloserSides, OfNoPointsAreNobodys) {
  const Eigen::Matrix3Xd none(3, 0);
  EXPECT_FALSE(has_closer_sides(box_turned(0), box_turned(0.3), {{}, none, kRadius_m, {}}));
}

// The share is (r^2 / (1 + r^2)), r the distance from the nearest side in twentieths of the radius: of one
// point r = 1 away from the best box, half; the other has to be within r^2 < 0.45 / 0.55.
TEST(CloserSides, CountByTheirDistanceInTwentiethsOfTheRadius) {
  const double near_m = 0.05 * kRadius_m, limit_m = near_m * std::sqrt(0.45 / 0.55);
  const Shape best = box_turned(0);
  Eigen::Matrix3Xd point(3, 1);
  point.col(0) = best.body_from_object * Eigen::Vector3d(kHalf.x() + near_m, 0, 0);
  for (const double factor : {0.98, 1.02}) {
    Shape other = best;
    other.semi_axes_m.x() += near_m - factor * limit_m;
    EXPECT_EQ(has_closer_sides(other, best, {{}, point, kRadius_m, {}}), factor < 1) << factor;
  }
}

}  // namespace
}  // namespace uniquadric
