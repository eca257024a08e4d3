#pragma once

#include <Eigen/Core>
#include <memory>

#include "core/geometry/pose.h"

namespace ceres {
class CostFunction;
}

namespace uniquadric {

/// Standard deviations of a pose's error.
struct PoseSigmas {
  double translation_m = 0.01;
  double rotation_rad = 0.01;
};

/// Rigid prior (Eq. 16): r = Log(T_prior^-1 T), rotation and translation weighted apart, T_prior the pose
/// that the short window found. The paper prints the caption of Eq. 15 under it. Block: T (7).
std::unique_ptr<ceres::CostFunction> pose_prior_factor(const Pose& prior, const PoseSigmas& sigmas);

/// The same with any square root of the information, r = S Log(T_prior^-1 T), in the order (rho, phi): the
/// marginal prior of a pose.
std::unique_ptr<ceres::CostFunction> pose_prior_factor(const Pose& prior,
                                                       const Eigen::Matrix<double, 6, 6>& sqrt_information);

/// A measured pose of b in a: r = Log(a_from_b^-1 T_a^-1 T_b), weighted apart.
/// Blocks: T_a = world_from_a (7), T_b = world_from_b (7).
std::unique_ptr<ceres::CostFunction> relative_pose_factor(const Pose& a_from_b, const PoseSigmas& sigmas);

/// What is left of the observations that have gone from the short window (e_prior of Eq. 5):
/// r = S (p - p0), with S^T S the information about the landmark at the linearisation point p0 [m].
/// Block: p (3).
std::unique_ptr<ceres::CostFunction> landmark_prior_factor(const Eigen::Vector3d& p0,
                                                           const Eigen::Matrix3d& sqrt_information);

}  // namespace uniquadric
