#include "core/geometry/ellipsoid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/base/random.h"

namespace uniquadric {
namespace {

const Camera kCamera{640, 480, 500, 510, 320, 230, {}};

Pose pose_at(const Eigen::Vector3d& t, const Eigen::Vector3d& rotation = {0.3, -0.8, 0.5}) {
  return {exp_so3(rotation), t};
}

TEST(DualConic, Eq11_ProjectsSphereOnAxisToCircle) {
  // A sphere of radius r at distance d on the optical axis: tangent rays at sin(alpha) = r / d.
  const double r = 0.3, d = 2;
  const Camera camera{640, 480, 500, 500, 320, 240, {}};
  const auto view = project(camera, pose_at({0, 0, d}), Eigen::Vector3d::Constant(r));
  ASSERT_EQ(view.status, ProjectionStatus::ok);
  const double radius = 500 * std::tan(std::asin(r / d));
  EXPECT_NEAR(view.ellipse.semi_major, radius, 1e-9);
  EXPECT_NEAR(view.ellipse.semi_minor, radius, 1e-9);
  EXPECT_LT((view.ellipse.center - Eigen::Vector2d(320, 240)).norm(), 1e-9);
}

// The second way: the formula of the paper, with 4x4 and 3x3 matrices throughout.
TEST(DualConic, Eq8To11_AgreeWithThePlainMatrixFormula) {
  RandomStream random(1, "ellipsoids");
  int cases = 0;
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d a(random.uniform(0.1, 1), random.uniform(0.1, 1), random.uniform(0.1, 1));
    const Pose pose = pose_at({random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(1.5, 4)},
                              {random.normal(), random.normal(), random.normal()});
    const auto view = project(kCamera, pose, a);
    ASSERT_EQ(view.status, ProjectionStatus::ok);
    const Eigen::Matrix<double, 3, 4> P = kCamera.matrix() * Eigen::Matrix<double, 3, 4>::Identity();
    const Eigen::Matrix3d C = P * dual_quadric(pose, a) * P.transpose();
    const Ellipse plain = ellipse_from_dual_conic(C);
    EXPECT_LT((view.ellipse.center - plain.center).norm(), 1e-8);
    EXPECT_LT((ellipse_covariance(view.ellipse) - ellipse_covariance(plain)).norm(),
              1e-6);  // px^2, of about 1e4
    ++cases;
  }
  EXPECT_EQ(cases, 200);
}

// A tangent line of the outline back-projects to a plane that touches the ellipsoid.
TEST(DualConic, OutlineLinesBackProjectToTangentPlanes) {
  const Eigen::Vector3d a(0.5, 0.2, 0.9);
  const Pose pose = pose_at({0.4, -0.3, 2});
  const auto view = project(kCamera, pose, a);
  ASSERT_EQ(view.status, ProjectionStatus::ok);
  const Eigen::Matrix2d sigma = ellipse_covariance(view.ellipse);
  for (int k = 0; k < 12; ++k) {
    const double angle = k * std::numbers::pi / 6;
    const Eigen::Vector2d n(std::cos(angle), std::sin(angle));
    const double offset =
        n.dot(view.ellipse.center) + std::sqrt(n.dot(sigma * n));  // line n.x = offset touches
    const Eigen::Vector3d plane = kCamera.matrix().transpose() * Eigen::Vector3d(n.x(), n.y(), -offset);
    const double reach = (pose.rotation.conjugate() * plane).cwiseProduct(a).norm();
    EXPECT_NEAR(plane.dot(pose.translation) + reach, 0, 1e-9 * plane.norm());
  }
}

TEST(DualConic, Eq13_RotBboxSurvivesTheDualConic) {
  int cases = 0;
  for (const double angle : {0.0, 0.4, std::numbers::pi / 2, 2.9}) {
    const Ellipse ellipse{{310, 200}, 80, 20, angle};
    const Ellipse back = ellipse_from_dual_conic(-3.5 * dual_conic(ellipse));  // any scale and sign
    EXPECT_NEAR(back.semi_major, 80, 1e-8);
    EXPECT_NEAR(back.semi_minor, 20, 1e-8);
    EXPECT_NEAR(back.angle_rad, angle, 1e-9);
    EXPECT_LT((back.center - ellipse.center).norm(), 1e-9);
    ++cases;
  }
  EXPECT_EQ(cases, 4);
}

TEST(Projection, EachFailureIsAnOutcomeOfItsOwn) {
  const Eigen::Vector3d a(1, 0.5, 0.5);
  const auto status = [&](const Eigen::Vector3d& t) {
    return project(kCamera, {Eigen::Quaterniond::Identity(), t}, a).status;
  };
  EXPECT_EQ(status({0, 0, 2}), ProjectionStatus::ok);
  EXPECT_EQ(status({0, 0, -2}), ProjectionStatus::behind);
  EXPECT_EQ(status({3, 0, -0.5}), ProjectionStatus::behind);  // touches the principal plane from behind
  EXPECT_EQ(status({3, 0, 0.3}), ProjectionStatus::not_an_ellipse);
  EXPECT_EQ(status({3, 0, -0.3}), ProjectionStatus::not_an_ellipse);
  EXPECT_EQ(status({3, 0, 0.5}), ProjectionStatus::not_an_ellipse);
  EXPECT_EQ(status({0.2, 0, 0.1}), ProjectionStatus::inside);
  EXPECT_EQ(status({1, 0, 0}), ProjectionStatus::inside);  // camera centre on the surface
}

TEST(Projection, KeepsItsDigitsFarAway) {
  // 1 mm at 1 km: the direct difference of C* and mu mu^T would lose every digit.
  const double r = 1e-3, d = 1e3;
  const auto view = project(kCamera, pose_at({300, 0, d}), Eigen::Vector3d::Constant(r));
  ASSERT_EQ(view.status, ProjectionStatus::ok);
  EXPECT_NEAR(view.ellipse.semi_minor / (510 * r / d), 1, 1e-6);
  EXPECT_NEAR(view.ellipse.semi_major / (500 * r / d * std::sqrt(1 + 0.09)), 1, 1e-6);
}

}  // namespace
}  // namespace uniquadric
