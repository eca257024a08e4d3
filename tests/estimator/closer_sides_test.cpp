#include "estimator/objects/closer_sides.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include "core/base/random.h"
#include "core/geometry/box_symmetry.h"
#include "estimator/shape/oriented_box.h"

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

// An angle of arms of 0.6 and 0.5 m, 0.08 m thick and 0.2 m wide: points on all its sides, noise_m off. Its
// box is about box_turned(0)'s middle.
const Eigen::Vector3d kAngleHalf(0.3, 0.25, 0.1);

Eigen::Matrix3Xd points_of_angle(double noise_m) {
  constexpr double kThick_m = 0.08;
  const Eigen::Vector2d low(-kAngleHalf.x(), -kAngleHalf.y()), high(kAngleHalf.x(), kAngleHalf.y());
  const Eigen::Vector2d inner = low.array() + kThick_m;
  const std::array<Eigen::Vector2d, 7> corners = {
      low,   Eigen::Vector2d(high.x(), low.y()),   Eigen::Vector2d(high.x(), inner.y()),
      inner, Eigen::Vector2d(inner.x(), high.y()), Eigen::Vector2d(low.x(), high.y()),
      low};
  RandomStream random(2, "angle");
  Eigen::Matrix3Xd points(3, 900);
  for (int i = 0; i < points.cols(); ++i) {
    const Eigen::Vector2d at = corners[i % 6] + random.uniform() * (corners[i % 6 + 1] - corners[i % 6]);
    const Eigen::Vector3d p(at.x(), at.y(), kAngleHalf.z() * random.uniform(-1, 1));
    points.col(i) = box_turned(0).body_from_object *
                    Eigen::Vector3d(p + noise_m * Eigen::Vector3d(random.normal(), random.normal(), 0));
  }
  return points;
}

// Cameras two metres off along each axis, each of which is given all points.
class AllRound {
 public:
  explicit AllRound(const Eigen::Matrix3Xd& points) {
    const Eigen::Vector3d middle = box_turned(0).body_from_object.translation;
    for (int i = 0; i < 6; ++i) {
      const Eigen::Vector3d away = (i < 3 ? 2 : -2) * Eigen::Vector3d::Unit(i % 3);
      const Pose body_from_camera{Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), -away),
                                  middle + away};
      const Pose camera_from_body = body_from_camera.inverse();
      in_camera_[i].resize(3, points.cols());
      for (Eigen::Index k = 0; k < points.cols(); ++k)
        in_camera_[i].col(k) = camera_from_body * Eigen::Vector3d(points.col(k));
      views.push_back({body_from_camera, &in_camera_[i]});
    }
  }
  std::vector<PointView> views;

 private:
  std::array<Eigen::Matrix3Xd, 6> in_camera_;
};

// The least angle between the axes of two boxes, however they are named.
double turn_between(const Shape& shape, const Eigen::Matrix3d& axes) {
  const Eigen::Matrix3d own = shape.body_from_object.rotation.toRotationMatrix();
  return Eigen::AngleAxisd(axes.transpose() * own * nearest_box_rotation(own, axes)).angle();
}

// A convex shape lies along the line between the ends of its arms: here the true one to within a degree.
TEST(BoxAbout, AnAngleHasTheAxesOfItsArms) {
  const double across_rad = -std::atan2(kAngleHalf.y(), kAngleHalf.x());
  const Shape along_hull = box_turned(across_rad, {0.39, 0.2, 0.1});
  const Eigen::Matrix3Xd points = points_of_angle(0.004);
  const AllRound round(points);
  const auto found = box_about(along_hull, {}, true, {round.views, points, kRadius_m, {}});
  ASSERT_TRUE(found);
  const Shape& box = *found;
  Eigen::Vector3d sorted = box.semi_axes_m;
  std::sort(sorted.begin(), sorted.end(), std::greater<>());
  EXPECT_LT((sorted - kAngleHalf).cwiseAbs().maxCoeff(), 0.01) << sorted.transpose();
  EXPECT_LT((box.body_from_object.translation - box_turned(0).body_from_object.translation).norm(), 0.01);
  EXPECT_LT(turn_between(box, Eigen::Matrix3d::Identity()), 0.02);
  // named as the shape's axes are that they are nearest to
  EXPECT_LT(along_hull.body_from_object.rotation.angularDistance(box.body_from_object.rotation),
            std::numbers::pi / 4);
  // kept without a look, in the place of what the fit says by then
  const auto later = box_about(box_turned(across_rad + 0.05, {0.39, 0.2, 0.1}), box, false,
                               {round.views, points, kRadius_m, {}});
  ASSERT_TRUE(later);
  EXPECT_EQ(later->body_from_object.rotation.angularDistance(box.body_from_object.rotation), 0);
}

// Its own axes fill the smallest box: nothing is turned, and nothing is kept.
TEST(BoxAbout, OfAConvexBodyIsItsShape) {
  const Shape shape = box_turned(0);
  for (const double noise_m : {0.0, 0.005}) {
    const Eigen::Matrix3Xd points = points_of_sides(noise_m);
    EXPECT_FALSE(box_about(shape, {}, true, {{}, points, kRadius_m, {}})) << noise_m;
  }
}

// Of what a camera sees of an ellipsoid a box along other axes is smaller, but no point lies off its surface.
TEST(BoxAbout, OfWhatTheShapeFollowsIsItsOwn) {
  RandomStream random(3, "ellipsoid");
  Eigen::Matrix3Xd points(3, 600);
  for (int i = 0; i < points.cols(); ++i) {
    const Eigen::Vector3d out(random.normal(), random.normal(), random.normal());
    points.col(i) = out.normalized() * (out.sum() > 0 ? 1 : -1);
  }
  const Eigen::Matrix3d along =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitX(), Eigen::Vector3d(1, 1, 1))
          .toRotationMatrix();
  const OrientedBox own = box_along(Eigen::Matrix3d::Identity(), points), turned = box_along(along, points);
  ASSERT_LT(turned.half_extents_m.prod(), 0.9 * own.half_extents_m.prod());
  Shape ball;
  ball.semi_axes_m.setOnes();
  ball.exponents = {2, 2, 2};
  EXPECT_FALSE(box_about(ball, {}, true, {{}, points, 1, {}}));
  Shape before = ball;
  before.body_from_object.rotation = along;
  EXPECT_FALSE(box_about(ball, before, false, {{}, points, 1, {}}));
}

// Axes of before that the points contradict by now are given up.
TEST(BoxAbout, ForgetsAxesThatTheBodyOutgrew) {
  const Eigen::Matrix3Xd points = points_of_sides(0.003);
  EXPECT_FALSE(box_about(box_turned(0), box_turned(0.4), false, {{}, points, kRadius_m, {}}));
}

TEST(BoxAbout, OfNoPointsIsTheShape) {
  const Eigen::Matrix3Xd none(3, 0);
  EXPECT_FALSE(box_about(box_turned(0.3), {}, true, {{}, none, kRadius_m, {}}));
}

}  // namespace
}  // namespace uniquadric
