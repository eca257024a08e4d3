#include "estimator/factors/reprojection.h"

#include <ceres/cost_function.h>
#include <gtest/gtest.h>

#include "estimator/factors/pose_block.h"
#include "tests/estimator/factors/jacobian_check.h"

namespace uniquadric {
namespace {

const Camera kCamera{640, 480, 500, 510, 320, 235, {}};
const Pose kWorldFromCamera{exp_so3({0.2, -0.4, 0.1}), {3, -2, 1}};
const Eigen::Vector3d kPoint(0.12, -0.2, 0.3);

Pose body_ahead(const Eigen::Quaterniond& rotation, double z = 2.2) {
  return kWorldFromCamera * Pose{rotation, {0.3, -0.1, z}};
}

Feature feature(bool depth) {
  Feature f;
  f.pixel = {350, 200};
  if (depth) f.depth_m = 2.3, f.depth_sigma_m = 0.011;
  return f;
}

// The second way: the camera's own projection of the point.
TEST(Reprojection, Eq6_IsTheCamerasProjectionMinusTheSighting) {
  const Pose world_from_body = body_ahead(exp_so3({0.5, 0.6, -0.2}));
  const auto cost = reprojection_factor(kCamera, kWorldFromCamera, feature(true), 0.7);
  const Eigen::VectorXd r = residuals_of(*cost, blocks_of(pose_block(world_from_body), kPoint));
  const Eigen::Vector3d in_camera = kWorldFromCamera.inverse() * (world_from_body * kPoint);
  EXPECT_LT((r.head<2>() - (*kCamera.project(in_camera) - Eigen::Vector2d(350, 200)) / 0.7).norm(), 1e-10);
  EXPECT_NEAR(r[2], (in_camera.z() - 2.3) / 0.011, 1e-10);
}

TEST(Reprojection, Eq6_WithoutDepthHasTwoRows) {
  Feature unknown_sigma = feature(false);
  unknown_sigma.depth_m = 2;
  EXPECT_EQ(reprojection_factor(kCamera, kWorldFromCamera, feature(false), 1)->num_residuals(), 2);
  EXPECT_EQ(reprojection_factor(kCamera, kWorldFromCamera, unknown_sigma, 1)->num_residuals(), 2);
}

TEST(Reprojection, Eq6_JacobianMatchesDifferences) {
  for (const auto& rotation : test_rotations())
    for (const bool depth : {false, true})
      expect_jacobians(*reprojection_factor(kCamera, kWorldFromCamera, feature(depth), 0.7),
                       blocks_of(pose_block(body_ahead(rotation)), kPoint));
}

TEST(Reprojection, Eq6_BehindTheCameraIsFiniteAndContinuous) {
  const auto cost = reprojection_factor(kCamera, kWorldFromCamera, feature(true), 1);
  const Eigen::Vector3d at_origin = Eigen::Vector3d::Zero();
  const auto at = [&](double z) {
    return blocks_of(pose_block(body_ahead(Eigen::Quaterniond::Identity(), z)), at_origin);
  };
  for (const double z : {-3.0, 0.0, 0.05}) {
    EXPECT_TRUE(residuals_of(*cost, at(z)).allFinite());
    expect_jacobians(*cost, at(z));
  }
  EXPECT_LT((residuals_of(*cost, at(0.1 + 1e-9)) - residuals_of(*cost, at(0.1 - 1e-9))).norm(), 1e-3);
}

}  // namespace
}  // namespace uniquadric
