#include "estimator/factors/tangent.h"

#include <ceres/cost_function.h>
#include <ceres/problem.h>
#include <ceres/sized_cost_function.h>
#include <ceres/solver.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "core/geometry/ellipsoid.h"
#include "estimator/factors/pose_block.h"
#include "estimator/factors/shape_block.h"
#include "estimator/factors/solver_log.h"
#include "tests/estimator/factors/jacobian_check.h"

namespace uniquadric {
namespace {

const Camera kCamera{640, 480, 500, 510, 320, 235, {}};
const Pose kWorldFromCamera{exp_so3({0.2, -0.4, 0.1}), {3, -2, 1}};
const Pose kBodyFromShape{exp_so3({-0.3, 0.2, 0.8}), {0.05, -0.02, 0.04}};
const Eigen::Vector3d kAxes(0.3, 0.15, 0.22);
constexpr double kDepth = 2.2;  // m

Pose body_at(const Eigen::Quaterniond& rotation) {
  return kWorldFromCamera * Pose{rotation, {0.3, -0.1, kDepth}};
}

Eigen::Vector2d direction(int i, int of) {
  return {std::cos(2 * M_PI * i / of), std::sin(2 * M_PI * i / of)};
}

std::vector<double> exponents(double q, int count) {
  return std::vector<double>(static_cast<std::size_t>(count), exponent_block(q));
}

Blocks blocks_at(const Pose& body, const std::vector<double>& exponent) {
  return blocks_of(pose_block(body), pose_block(kBodyFromShape), axes_block(kAxes), exponent);
}

// Support line of the ellipse's outline: n . center + sqrt(n^T Sigma n).
SupportLine line_of(const Ellipse& ellipse, const Eigen::Vector2d& n) {
  return {n, n.dot(ellipse.center) + std::sqrt(n.dot(ellipse_covariance(ellipse) * n)), true};
}

// Support line of a box's image: the furthest of its eight corners.
SupportLine line_of_box(const Pose& camera_from_box, const Eigen::Vector3d& half, const Eigen::Vector2d& n) {
  SupportLine line{n, -std::numeric_limits<double>::infinity(), true};
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d sign(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
    const auto pixel = kCamera.project(camera_from_box * half.cwiseProduct(sign));
    line.offset_px = std::max(line.offset_px, n.dot(*pixel));
  }
  return line;
}

TEST(TangentFactor, EllipsoidTouchesTheTangentsOfItsOutline) {
  for (const auto& rotation : test_rotations()) {
    const Pose body = body_at(rotation);
    const Pose camera_from_shape = relative_pose(kWorldFromCamera, body) * kBodyFromShape;
    const Ellipse outline = project(kCamera, camera_from_shape, kAxes).ellipse;
    for (int i = 0; i < 16; ++i) {
      const TangentPlane plane =
          tangent_plane(kCamera, kWorldFromCamera, line_of(outline, direction(i, 16)), kDepth);
      for (const int count : {1, 3}) {
        const auto cost = tangent_factor(plane, {count, 1, 0});
        EXPECT_LT(std::abs(residuals_of(*cost, blocks_at(body, exponents(2, count)))[0]), 1e-9);  // px
      }
    }
  }
}

TEST(TangentFactor, BoxTouchesItsOwnSupportLinesAsTheExponentFallsToOne) {
  const Pose body = body_at(exp_so3({0.5, 0.6, -0.2}));
  const Pose camera_from_shape = relative_pose(kWorldFromCamera, body) * kBodyFromShape;
  for (int i = 0; i < 16; ++i) {
    const SupportLine line = line_of_box(camera_from_shape, kAxes, direction(i, 16));
    const TangentPlane plane = tangent_plane(kCamera, kWorldFromCamera, line, kDepth);
    const auto cost = tangent_factor(plane, {1, 1, 0});
    // q - 1 = 4e-18, lost beside 1: the box itself.
    EXPECT_LT(std::abs(residuals_of(*cost, blocks_at(body, {-40}))[0]), 1e-9);
    EXPECT_GT(std::abs(residuals_of(*cost, blocks_at(body, exponents(2, 1)))[0]), 1);  // the quadric is off
  }
}

// pi^T Q* pi = 0 of Eq. 11's dual quadric, for a plane through the camera.
TEST(TangentFactor, ExponentTwoIsTheDualQuadric) {
  const Pose body = body_at(exp_so3({0.5, 0.6, -0.2}));
  const Eigen::Matrix4d Q = dual_quadric(body * kBodyFromShape, kAxes);
  const TangentPlane plane = tangent_plane(kCamera, kWorldFromCamera, {direction(3, 16), 250, true}, kDepth);
  const double r = residuals_of(*tangent_factor(plane, {1, 1, 0}), blocks_at(body, exponents(2, 1)))[0];
  // With x = n . t + d and h: pi^T Q* pi = h^2 - x^2 = (h + x)(h - x).
  const Eigen::Vector4d pi(plane.normal.x(), plane.normal.y(), plane.normal.z(), plane.offset_m);
  const double x = plane.normal.dot((body * kBodyFromShape).translation) + plane.offset_m;
  const double sum = r / plane.px_per_m;  // x + h
  EXPECT_NEAR(pi.dot(Q * pi), sum * (sum - 2 * x), 1e-12);
}

TEST(TangentFactor, ResidualIsThePixelsByWhichTheLineIsOff) {
  const Pose body = body_at(exp_so3({0.5, 0.6, -0.2}));
  const Pose camera_from_shape = relative_pose(kWorldFromCamera, body) * kBodyFromShape;
  const Ellipse outline = project(kCamera, camera_from_shape, kAxes).ellipse;
  for (int i = 0; i < 16; ++i) {
    SupportLine line = line_of(outline, direction(i, 16));
    line.offset_px -= 2;  // the body reaches 2 px too far
    const auto cost = tangent_factor(tangent_plane(kCamera, kWorldFromCamera, line, kDepth), {1, 0.5, 0});
    EXPECT_NEAR(residuals_of(*cost, blocks_at(body, exponents(2, 1)))[0], 2 / 0.5,
                0.4);  // depth varies by 10 %
  }
}

// With axes of exp(700) m the distance is a number still, its pixels and derivatives by the sigma are none.
TEST(TangentFactor, WhatIsNoNumberIsRefused) {
  const TangentPlane plane = tangent_plane(kCamera, kWorldFromCamera, {direction(1, 16), 300, true}, kDepth);
  Blocks blocks = blocks_at(body_at(test_rotations()[0]), exponents(1.5, 1));
  const auto is_usable = [&](double sigma_px) {
    std::vector<const double*> pointers;
    for (const auto& block : blocks) pointers.push_back(block.data());
    double residual = 0;
    return tangent_factor(plane, {1, sigma_px, 1e-3})->Evaluate(pointers.data(), &residual, nullptr);
  };
  EXPECT_TRUE(is_usable(0.01));
  blocks[2] = {700, 700, 700};
  EXPECT_TRUE(is_usable(1000));
  EXPECT_FALSE(is_usable(0.001));
}

// A cost that is no number makes the solver warn, several times.
TEST(SolverLog, IsSilentOnceItIsToldTo) {
  struct NoNumber : ceres::SizedCostFunction<1, 1> {
    bool Evaluate(double const* const*, double* residuals, double** jacobians) const override {
      residuals[0] = NAN;
      if (jacobians && jacobians[0]) jacobians[0][0] = NAN;
      return true;
    }
  };
  const auto said = [] {
    double x = 1;
    ceres::Problem problem;
    problem.AddResidualBlock(new NoNumber, nullptr, &x);
    ceres::Solver::Options options;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    testing::internal::CaptureStderr();
    ceres::Solve(options, &problem, &summary);
    EXPECT_FALSE(summary.IsSolutionUsable());
    return testing::internal::GetCapturedStderr();
  };
  EXPECT_NE(said(), "");
  keep_solver_silent();
  EXPECT_EQ(said(), "");
}

TEST(TangentFactor, JacobianMatchesDifferences) {
  int tested = 0;
  for (const auto& rotation : test_rotations())
    for (const int count : {1, 3})
      for (const double q : {1.05, 1.4, 1.9, 2.0})
        for (const int i : {1, 6, 11}) {
          const TangentPlane plane =
              tangent_plane(kCamera, kWorldFromCamera, {direction(i, 16), 300, true}, kDepth);
          expect_jacobians(*tangent_factor(plane, {count, 2, 1e-3}),
                           blocks_at(body_at(rotation), exponents(q, count)), 1e-5);
          ++tested;
        }
  EXPECT_EQ(tested, 72);
}

TEST(TangentFactor, JacobianMatchesWithThreeUnequalExponents) {
  const std::vector<double> unequal = {exponent_block(1.3), exponent_block(1.7), exponent_block(1.15)};
  for (const auto& rotation : test_rotations())
    for (int i = 0; i < 16; ++i) {
      const TangentPlane plane =
          tangent_plane(kCamera, kWorldFromCamera, {direction(i, 16), 300, true}, kDepth);
      expect_jacobians(*tangent_factor(plane, {3, 2, 1e-3}), blocks_at(body_at(rotation), unequal), 1e-5);
    }
}

}  // namespace
}  // namespace uniquadric
