#include "evaluation/report/outline.h"

#include <gtest/gtest.h>

#include <numbers>

#include "core/geometry/ellipsoid.h"
#include "core/geometry/superquadric.h"

namespace uniquadric {
namespace {

const Eigen::Vector3d kAxes_m(0.5, 0.3, 0.2);
const Pose kAside{exp_so3({0.4, -0.7, 1.1}), Eigen::Vector3d(0.6, -0.4, 3)};

// How far a set of points reaches in the direction of an angle [px].
double reach(const std::vector<Eigen::Vector2d>& points, double angle_rad) {
  double most = -1e9;
  for (const Eigen::Vector2d& p : points)
    most = std::max(most, p.dot(Eigen::Vector2d(std::cos(angle_rad), std::sin(angle_rad))));
  return most;
}

TEST(Outline, OfAnEllipsoidLiesOnTheEllipseThatItsConicGives) {
  const Camera camera;
  const Ellipse e = project(camera, kAside, kAxes_m).ellipse;
  const auto outline = superellipsoid_outline(camera, kAside, {kAxes_m});
  ASSERT_EQ(outline.size(), 360u);
  for (const Eigen::Vector2d& p : outline) {
    const Eigen::Vector2d local = Eigen::Rotation2Dd(-e.angle_rad) * (p - e.center);
    EXPECT_NEAR(local.cwiseQuotient(Eigen::Vector2d(e.semi_major, e.semi_minor)).norm(), 1, 1e-6);
  }
}

// Of the box: only corners are touched, and those that stick out are.
TEST(Outline, OfABoxHasItsCorners) {
  const Camera camera;
  std::vector<Eigen::Vector2d> corners;
  for (int signs = 0; signs < 8; ++signs) {
    const Eigen::Vector3d sign(signs & 1 ? 1 : -1, signs & 2 ? 1 : -1, signs & 4 ? 1 : -1);
    corners.push_back(*camera.project(kAside * sign.cwiseProduct(kAxes_m).eval()));
  }
  {
    const auto outline = superellipsoid_outline(camera, kAside, {kAxes_m, {1, 1, 1}});
    ASSERT_EQ(outline.size(), 360u);
    for (const Eigen::Vector2d& p : outline) {
      const auto is_there = [&](const Eigen::Vector2d& corner) { return (corner - p).norm() < 1e-6; };
      EXPECT_TRUE(std::any_of(corners.begin(), corners.end(), is_there)) << p.transpose();
    }
    for (int i = 0; i < 360; ++i) {
      const double angle_rad = i * std::numbers::pi / 180;
      EXPECT_NEAR(reach(outline, angle_rad), reach(corners, angle_rad), 1e-6) << i;
    }
  }
}

// A tube along any of its axes touches its tangents with its rims.
TEST(Outline, OfACylinderIsThatOfItsRims) {
  const Camera camera;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<Eigen::Vector2d> rims;
    for (int i = 0; i < 7200; ++i) {
      const double angle_rad = i * std::numbers::pi / 1800;
      Eigen::Vector3d point;
      point[axis] = (i < 3600 ? 1 : -1) * kAxes_m[axis];
      point[(axis + 1) % 3] = std::cos(angle_rad) * kAxes_m[(axis + 1) % 3];
      point[(axis + 2) % 3] = std::sin(angle_rad) * kAxes_m[(axis + 2) % 3];
      rims.push_back(*camera.project(kAside * point));
    }
    const auto outline = superellipsoid_outline(camera, kAside, {kAxes_m, {2, 1, 1}, axis});
    for (int i = 0; i < 360; ++i) {
      const double angle_rad = i * std::numbers::pi / 180;
      EXPECT_NEAR(reach(outline, angle_rad), reach(rims, angle_rad), 1e-3) << axis << ' ' << i;
    }
  }
}

// Between the two no point of the surface lies outside, and some lie on it.
TEST(Outline, OfARoundedBoxHoldsItsWholeSurface) {
  const Camera camera;
  constexpr double kExponent = 1.3, kSampling_px = 0.1;
  std::vector<Eigen::Vector2d> surface;
  for (int i = 0; i < 400; ++i)
    for (int j = 0; j < 800; ++j) {
      const double polar = (i + 0.5) * std::numbers::pi / 400, azimuth = j * std::numbers::pi / 400;
      const Eigen::Vector3d normal(std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth),
                                   std::cos(polar));
      surface.push_back(*camera.project(
          kAside * superellipsoid_support_point(kAxes_m, kExponent, normal.cwiseQuotient(kAxes_m))));
    }
  const auto outline = superellipsoid_outline(camera, kAside, {kAxes_m, {kExponent, kExponent, kExponent}});
  for (int i = 0; i < 360; ++i) {
    const double angle_rad = i * std::numbers::pi / 180;
    EXPECT_LE(reach(surface, angle_rad), reach(outline, angle_rad) + 1e-6) << i;
    EXPECT_GE(reach(surface, angle_rad), reach(outline, angle_rad) - kSampling_px) << i;
  }
}

TEST(Outline, NoneOfWhatIsNotWhollyInFrontOfTheCamera) {
  int cases = 0;
  for (const double z_m : {-3.0, 0.0, 0.1, 0.19})
    for (const double exponent : {1.0, 1.5, 2.0}) {
      const Pose pose{Eigen::Quaterniond::Identity(), Eigen::Vector3d(2, 0, z_m)};
      EXPECT_TRUE(superellipsoid_outline(Camera{}, pose, {kAxes_m, {exponent, exponent, exponent}}).empty())
          << z_m;
      ++cases;
    }
  EXPECT_EQ(cases, 12);
  const Pose in_front{Eigen::Quaterniond::Identity(), Eigen::Vector3d(2, 0, 0.3)};
  EXPECT_EQ(superellipsoid_outline(Camera{}, in_front, {kAxes_m, {1.5, 1.5, 1.5}}).size(), 360u);
}

}  // namespace
}  // namespace uniquadric
