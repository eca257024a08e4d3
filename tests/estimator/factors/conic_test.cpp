#include "estimator/factors/conic.h"

#include <ceres/cost_function.h>
#include <ceres/manifold.h>
#include <ceres/problem.h>
#include <ceres/solver.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/random.h"
#include "estimator/factors/pose_block.h"
#include "estimator/factors/shape_block.h"
#include "tests/estimator/factors/jacobian_check.h"

namespace uniquadric {
namespace {

const Camera kCamera{640, 480, 500, 510, 320, 235, {}};
const Pose kWorldFromCamera{exp_so3({0.2, -0.4, 0.1}), {3, -2, 1}};
const Pose kBodyFromShape{exp_so3({-0.3, 0.2, 0.8}), {0.05, -0.02, 0.04}};
const Eigen::Vector3d kAxes(0.3, 0.15, 0.22);
const ConicOptions kVector{ConicResidual::vector, 0.5}, kLiteral{ConicResidual::literal, 0.5};

Pose body_at(const Eigen::Quaterniond& rotation, double z = 2.2) {
  return kWorldFromCamera * Pose{rotation, {0.3, -0.1, z}};
}

Ellipse true_outline(const Pose& world_from_body, const Eigen::Vector3d& axes = kAxes) {
  const auto seen = project(kCamera, relative_pose(kWorldFromCamera, world_from_body) * kBodyFromShape, axes);
  EXPECT_EQ(seen.status, ProjectionStatus::ok);
  return seen.ellipse;
}

Blocks blocks_at(const Pose& world_from_body, const Eigen::Vector3d& axes = kAxes) {
  return blocks_of(pose_block(world_from_body), pose_block(kBodyFromShape), axes_block(axes));
}

TEST(ConicFactor, Eq11_TheTrueOutlineHasNoResidual) {
  for (const auto& rotation : test_rotations()) {
    const Pose body = body_at(rotation);
    for (const auto& options : {kVector, kLiteral}) {
      const auto cost = conic_factor(kCamera, kWorldFromCamera, true_outline(body), options);
      EXPECT_LT(residuals_of(*cost, blocks_at(body)).norm(), 1e-6);
    }
  }
}

TEST(ConicFactor, Eq14_LiteralFormIsTheRootOfTwiceTheBhattacharyyaDistance) {
  const Pose body = body_at(exp_so3({0.5, 0.6, -0.2}));
  const Ellipse observed{{330, 210}, 70, 45, 0.7};
  const auto cost = conic_factor(kCamera, kWorldFromCamera, observed, kLiteral);
  const double e_B = bhattacharyya_distance(observed, true_outline(body));
  EXPECT_NEAR(residuals_of(*cost, blocks_at(body))[0], std::sqrt(2 * e_B) / 0.5, 1e-10);
}

// e_B by its definition: -ln of the integral of sqrt(N_a N_b), summed on a grid.
TEST(ConicFactor, Eq14_IsTheBhattacharyyaDistanceOfTwoGaussians) {
  const Ellipse a{{1, 2}, 3, 1.5, 0.4}, b{{2.5, 1}, 2, 1, 2.0};
  const auto density = [](const Ellipse& e, const Eigen::Vector2d& x) {
    const Eigen::Matrix2d S = ellipse_covariance(e);
    const Eigen::Vector2d d = x - e.center;
    return std::exp(-0.5 * d.dot(S.inverse() * d)) / (2 * M_PI * std::sqrt(S.determinant()));
  };
  double overlap = 0;
  constexpr double kCell = 0.1;
  for (double x = -20; x < 24; x += kCell)
    for (double y = -20; y < 24; y += kCell)
      overlap += kCell * kCell * std::sqrt(density(a, {x, y}) * density(b, {x, y}));
  EXPECT_NEAR(bhattacharyya_distance(a, b), -std::log(overlap), 1e-9);
}

// |r|^2 = 2 e_B to second order: the difference falls with the cube of the perturbation.
TEST(ConicFactor, Eq14_VectorFormIsTwiceTheDistanceToSecondOrder) {
  const Pose body = body_at(exp_so3({0.5, 0.6, -0.2}));
  const auto cost = conic_factor(kCamera, kWorldFromCamera, true_outline(body), {ConicResidual::vector, 1});
  RandomStream random(1, "directions");
  for (int trial = 0; trial < 20; ++trial) {
    Vector6d xi;
    for (int i = 0; i < 6; ++i) xi[i] = random.normal();
    const Eigen::Vector3d growth(random.normal(), random.normal(), random.normal());
    const auto mismatch = [&](double scale) {
      const Pose moved = body * exp_se3(scale * xi);
      const Eigen::Vector3d axes = kAxes.cwiseProduct((scale * growth).array().exp().matrix());
      const double twice = 2 * bhattacharyya_distance(true_outline(body), true_outline(moved, axes));
      const double square = residuals_of(*cost, blocks_at(moved, axes)).squaredNorm();
      EXPECT_NEAR(square / twice, 1, 40 * scale);
      return std::abs(square - twice);
    };
    EXPECT_LT(mismatch(1e-4), mismatch(1e-3) * 5e-3 + 1e-14);  // 1/1000 but for higher orders
  }
}

TEST(ConicFactor, Eq14_JacobianMatchesDifferences) {
  const Ellipse observed{{330, 210}, 70, 45, 0.7}, upright{{350, 220}, 60, 60, 0};
  int tested = 0;
  for (const auto& rotation : test_rotations())
    for (const auto& ellipse : {observed, upright})
      for (const auto& options : {kVector, kLiteral}) {
        expect_jacobians(*conic_factor(kCamera, kWorldFromCamera, ellipse, options),
                         blocks_at(body_at(rotation)));
        ++tested;
      }
  EXPECT_EQ(tested, 12);
}

TEST(ConicFactor, Eq14_JacobianMatchesNearTheMinimumWhereTheLogarithmsMeet) {
  const Pose body = body_at(exp_so3({0.5, 0.6, -0.2}));
  const auto cost = conic_factor(kCamera, kWorldFromCamera, true_outline(body), kVector);
  expect_jacobians(*cost, blocks_at(body));
  expect_jacobians(*cost, blocks_at(body * Pose{exp_so3({1e-7, 0, 2e-7}), {1e-7, 0, 0}}));
}

TEST(ConicFactor, WithoutAnOutlineItIsAConstantOfZeroSlope) {
  const Ellipse observed{{330, 210}, 70, 45, 0.7};
  for (const double z : {-3.0, 0.0, 0.15})  // behind, about the camera, across the principal plane
    for (const auto& options : {kVector, kLiteral}) {
      const auto cost = conic_factor(kCamera, kWorldFromCamera, observed, options);
      const Blocks blocks = blocks_at(body_at(Eigen::Quaterniond::Identity(), z));
      EXPECT_NEAR(residuals_of(*cost, blocks).norm(), kNoOutlineResidual / 0.5, 1e-12);
      expect_jacobians(*cost, blocks);
    }
}

// Five numbers a view: three views of an ellipsoid give its nine parameters back. The body's frame is fixed.
TEST(ConicFactor, ThreeViewsOfAnEllipsoidGiveItsNineParameters) {
  PoseBlock body = pose_block({}), shape = pose_block({exp_so3({0.1, 0.2, 0.1}), {0.05, 0, -0.05}});
  AxesBlock axes = axes_block({0.2, 0.2, 0.25});
  const Ellipsoid truth{{exp_so3({0.2, 0.3, -0.1}), {0.1, 0.05, 0}}, {0.35, 0.15, 0.25}};
  ceres::Problem problem;
  for (const double turn : {-0.6, 0.0, 0.7}) {
    const Pose world_from_camera =
        Pose{exp_so3({0, turn, 0}), {0, 0, 0}} * Pose{exp_so3({0.2, 0, 0}), {0, 0.1, -2}};
    const auto seen =
        project(kCamera, world_from_camera.inverse() * truth.world_from_object, truth.semi_axes_m);
    ASSERT_EQ(seen.status, ProjectionStatus::ok);
    problem.AddResidualBlock(conic_factor(kCamera, world_from_camera, seen.ellipse).release(), nullptr,
                             body.data(), shape.data(), axes.data());
  }
  problem.SetParameterBlockConstant(body.data());
  problem.SetManifold(shape.data(), pose_manifold().release());
  ceres::Solver::Options options;
  options.max_num_iterations = 100;
  options.function_tolerance = options.gradient_tolerance = options.parameter_tolerance = 0;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  EXPECT_LT(summary.final_cost, 1e-16);
  EXPECT_LT((axes_from_block(axes.data()) - truth.semi_axes_m).norm(), 1e-6);
  EXPECT_TRUE(pose_from_block(shape).matrix().isApprox(truth.world_from_object.matrix(), 1e-6));
}

}  // namespace
}  // namespace uniquadric
