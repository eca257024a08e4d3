#include "core/geometry/pose.h"

#include <gtest/gtest.h>

#include <numbers>
#include <unsupported/Eigen/MatrixFunctions>

#include "core/base/random.h"

namespace uniquadric {
namespace {

constexpr double kRounding = 1e-12;  // a few dozen double operations on numbers near 1

Vector6d random_twist(RandomStream& random, double angle) {
  Vector6d xi;
  for (double& x : xi) x = random.normal();
  xi.tail<3>() *= angle / xi.tail<3>().norm();
  return xi;
}

Eigen::Matrix4d hat(const Vector6d& xi) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Zero();
  m(2, 1) = xi[3], m(1, 2) = -xi[3], m(0, 2) = xi[4], m(2, 0) = -xi[4], m(1, 0) = xi[5], m(0, 1) = -xi[5];
  m.topRightCorner<3, 1>() = xi.head<3>();
  return m;
}

TEST(Pose, ExpEqualsTheMatrixExponential) {
  RandomStream random(1, "twists");
  int cases = 0;
  for (const double angle : {0.0, 1e-9, 1e-5, 9.9e-5, 1.1e-4, 0.0099, 0.0101, 1.0, 3.0, std::numbers::pi}) {
    const Vector6d xi = random_twist(random, angle);
    EXPECT_LT((exp_se3(xi).matrix() - hat(xi).exp()).norm(), kRounding) << "angle " << angle;
    ++cases;
  }
  EXPECT_EQ(cases, 10);
}

TEST(Pose, LogInvertsExpUpToPi) {
  RandomStream random(2, "twists");
  for (const double angle : {1e-9, 1e-5, 9.9e-5, 1.1e-4, 0.0099, 0.0101, 1.0, 3.0, std::numbers::pi - 1e-6}) {
    const Vector6d xi = random_twist(random, angle);
    EXPECT_LT((log_se3(exp_se3(xi)) - xi).norm(), 1e-9) << "angle " << angle;  // 1e-9: conditioning near pi
  }
}

TEST(Pose, LogTakesTheShorterOfTwoArcs) {
  const Eigen::Quaterniond q = exp_so3({0, 0, 0.5});
  const Eigen::Quaterniond opposite(-q.coeffs());
  EXPECT_LT((log_so3(opposite) - Eigen::Vector3d(0, 0, 0.5)).norm(), kRounding);
  const Eigen::Quaterniond small = exp_so3({0, 0, 1e-7});
  EXPECT_LT((log_so3(Eigen::Quaterniond(-small.coeffs())) - Eigen::Vector3d(0, 0, 1e-7)).norm(), 1e-19);
}

TEST(Pose, TransformsComposeAsMatrices) {
  RandomStream random(3, "twists");
  const Pose a = exp_se3(random_twist(random, 1)), b = exp_se3(random_twist(random, 2));
  EXPECT_LT(((a * b).matrix() - a.matrix() * b.matrix()).norm(), kRounding);
  EXPECT_LT(((a * a.inverse()).matrix() - Eigen::Matrix4d::Identity()).norm(), kRounding);
  const Eigen::Vector3d p(1, 2, 3);
  EXPECT_LT((a * p - (a.matrix() * p.homogeneous()).head<3>()).norm(), kRounding);
}

TEST(Pose, Eq3_InterpolatesAlongTheShortestArcAtConstantVelocity) {
  const Pose a{exp_so3({0, 0, 3.0}), {1, 0, 0}};
  const Pose b{exp_so3({0, 0, -3.0}), {3, 2, 0}};  // 0.283 rad further on, through pi
  const double step = 2 * std::numbers::pi - 6;
  for (const double u : {0.0, 0.25, 1.0, 1.5}) {
    const Pose p = interpolate(a, b, u);
    EXPECT_LT((p.translation - Eigen::Vector3d(1 + 2 * u, 2 * u, 0)).norm(), kRounding);
    EXPECT_LT(p.rotation.angularDistance(exp_so3({0, 0, 3.0 + u * step})), 1e-7);  // acos near 1
  }
}

TEST(Pose, RotationAngleIsExactAtZeroAndGoodNearPi) {
  const Eigen::Matrix3d R = exp_so3({0.3, -0.2, 0.7}).toRotationMatrix();
  EXPECT_EQ(rotation_angle(R.transpose() * R), 0.0);
  for (const double angle : {1e-12, 1e-3, 1.0, 3.0, std::numbers::pi - 1e-9})
    EXPECT_NEAR(rotation_angle(exp_so3(angle * Eigen::Vector3d(1, 2, -2) / 3).toRotationMatrix()), angle,
                kRounding);
}

}  // namespace
}  // namespace uniquadric
