#include <ceres/cost_function.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/random.h"
#include "estimator/factors/axis_direction.h"
#include "estimator/factors/pose_block.h"
#include "estimator/factors/shape_block.h"
#include "estimator/factors/shape_prior.h"
#include "estimator/factors/surface_point.h"
#include "tests/estimator/factors/jacobian_check.h"

namespace uniquadric {
namespace {

const Eigen::Vector3d kAxes(0.3, 0.15, 0.22);
const Pose kBodyFromShape{exp_so3({-0.3, 0.2, 0.8}), {0.05, -0.02, 0.04}};

TEST(ShapeBlock, AxesAndExponentsComeBack) {
  EXPECT_LT((axes_from_block(axes_block(kAxes).data()) - kAxes).norm(), 1e-16);
  for (const double q : {1.001, 1.3, 1.999}) EXPECT_NEAR(exponent_from_block(exponent_block(q)), q, 1e-14);
  EXPECT_EQ(exponent_from_block(exponent_block(2)), 2);
  EXPECT_EQ(exponent_from_block(exponent_block(1)), 1);
  for (const double s : {-3.0, 0.0, 2.0})
    EXPECT_NEAR(exponent_slope(s), (exponent_from_block(s + 1e-5) - exponent_from_block(s - 1e-5)) / 2e-5,
                1e-10);
  const double block[] = {exponent_block(1.2), exponent_block(1.5), exponent_block(1.7)};
  EXPECT_NEAR(exponents_from_block(block, 3).lower, 1.7, 1e-14);
  EXPECT_NEAR(exponents_from_block(block, 1).lower, 1.2, 1e-14);
}

TEST(AxisPrior, Eq15_IsTheDifferenceOverItsSigma) {
  const Eigen::Vector3d prior(0.28, 0.2, 0.22), sigma(0.01, 0.02, 0.04);
  const auto metres = axis_prior_factor(prior, sigma);
  const auto logarithmic = axis_prior_factor(prior, sigma, AxisScale::logarithmic);
  const Eigen::Vector3d r = residuals_of(*metres, blocks_of(axes_block(kAxes)));
  EXPECT_LT((r - (kAxes - prior).cwiseQuotient(sigma)).norm(), 1e-12);
  EXPECT_LT(residuals_of(*logarithmic, blocks_of(axes_block(prior))).norm(), 1e-12);
  // the same to first order
  const Eigen::Vector3d near = prior * 1.0001;
  EXPECT_LT((residuals_of(*metres, blocks_of(axes_block(near))) -
             residuals_of(*logarithmic, blocks_of(axes_block(near))))
                .norm(),
            1e-6);
  expect_jacobians(*metres, blocks_of(axes_block(kAxes)));
  expect_jacobians(*logarithmic, blocks_of(axes_block(kAxes)));
}

TEST(ExponentPrior, DrawsToTheQuadricAndKeepsTheBlockDetermined) {
  for (const int count : {1, 3}) {
    const auto cost = exponent_prior_factor(count);
    const std::vector<double> block = {0.4, -1.2, 2.5};
    const Blocks at{{block.begin(), block.begin() + count}};
    expect_jacobians(*cost, at);
    EXPECT_NEAR(residuals_of(*cost, at)[0], (exponent_from_block(0.4) - 2) / 2, 1e-15);
  }
  const auto cost = [&](double q) {
    return residuals_of(*exponent_prior_factor(1), {{exponent_block(q)}}).squaredNorm();
  };
  EXPECT_LT(cost(1.9), cost(1.5));
  EXPECT_LT(cost(1.5), cost(1.1));
}

TEST(ExponentPrior, HoldsBothProfilesTogetherAndLeavesTheOutline) {
  const auto cost = exponent_prior_factor(3, {.profile_sigma = 0.1});
  expect_jacobians(*cost, {{0.4, -1.2, 2.5}});
  const auto residual = [&](double outline, double upper, double lower) {
    return residuals_of(*cost, {{exponent_block(outline), exponent_block(upper), exponent_block(lower)}})[6];
  };
  EXPECT_NEAR(residual(1.9, 1.3, 1.3), 0, 1e-12);
  EXPECT_NEAR(residual(1.9, 1.5, 1.3), 2, 1e-9);
  EXPECT_EQ(residual(1.9, 1.5, 1.3), residual(1.2, 1.5, 1.3));
}

TEST(AxisDirection, IsTheAngleBetweenTheAxisAndTheDirection) {
  const Eigen::Vector3d direction = Eigen::Vector3d(0.3, -0.8, 0.4).normalized();
  const auto cost = axis_direction_factor(direction, 1, 0.02);
  for (const Eigen::Quaterniond& rotation : test_rotations()) {
    const Pose pose{rotation, {0.1, 0.2, 0.3}};
    expect_jacobians(*cost, blocks_of(pose_block(pose)));
    const double sine = (rotation * Eigen::Vector3d::UnitY()).cross(direction).norm();
    EXPECT_NEAR(residuals_of(*cost, blocks_of(pose_block(pose))).norm(), sine / 0.02, 1e-9);
  }
}

TEST(SurfacePoint, IsTheDistanceFromABallAndFromABoxsFace) {
  const Pose at{exp_so3({0.2, 0.5, -0.1}), {0.1, 0.2, 0.3}};
  const auto residual = [&](const Eigen::Vector3d& in_shape, const Eigen::Vector3d& axes, double q) {
    const auto cost = surface_point_factor(at * in_shape, 0.01, 1);
    const std::vector<double> exponent{exponent_block(q)};
    return residuals_of(*cost, blocks_of(pose_block(at), axes_block(axes), exponent))[0] * 0.01;
  };
  const Eigen::Vector3d ball = Eigen::Vector3d::Constant(0.2), n = Eigen::Vector3d(1, 2, -1).normalized();
  for (const double r : {0.15, 0.2, 0.3}) EXPECT_NEAR(residual(r * n, ball, 2), r - 0.2, 1e-12);
  EXPECT_NEAR(residual({0.32, 0.03, -0.05}, kAxes, 1.02), 0.02, 1e-4);
  EXPECT_NEAR(residual({0.02, -0.13, 0.1}, kAxes, 1.02), -0.02, 1e-4);
  EXPECT_NEAR(residual({0, 0, 0}, kAxes, 1.5), -0.15, 1e-12);  // the centre
}

// Points a small way along the normal off the surface, by the support function: the two forms of the body
// meet.
TEST(SurfacePoint, AgreesWithTheSupportFunctionOfThreeExponents) {
  const SuperExponents q{1.3, 1.8, 1.15};
  const std::vector<double> block = {exponent_block(1.3), exponent_block(1.8), exponent_block(1.15)};
  RandomStream random(4, "normals");
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d n = Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized();
    const Eigen::Vector3d on = superellipsoid_support_derivatives(kAxes, q, n).by_normal;
    for (const double off : {-1e-6, 0.0, 1e-6}) {
      const auto cost = surface_point_factor(kBodyFromShape * (on + off * n), 1, 3);
      EXPECT_NEAR(residuals_of(*cost, blocks_of(pose_block(kBodyFromShape), axes_block(kAxes), block))[0],
                  off, 1e-8);
    }
  }
}

TEST(SurfacePoint, JacobianMatchesDifferences) {
  int tested = 0;
  for (const auto& rotation : test_rotations())
    for (const int count : {1, 3})
      for (const double q : {1.1, 1.5, 1.95})
        for (const Eigen::Vector3d& point :
             {Eigen::Vector3d(0.3, 0.1, 0.15), Eigen::Vector3d(-0.1, 0.2, -0.1),
              Eigen::Vector3d(0.05, -0.04, 0.1)}) {
          const Pose at{rotation, {0.05, -0.02, 0.04}};
          const std::vector<double> exponent(static_cast<std::size_t>(count), exponent_block(q));
          expect_jacobians(*surface_point_factor(at * point, 0.1, count),
                           blocks_of(pose_block(at), axes_block(kAxes), exponent), 1e-6);
          ++tested;
        }
  EXPECT_EQ(tested, 54);
}

}  // namespace
}  // namespace uniquadric
