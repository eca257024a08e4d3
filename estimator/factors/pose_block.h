#pragma once

#include <array>
#include <memory>

#include "core/geometry/pose.h"

namespace ceres {
class Manifold;
}

namespace uniquadric {

/// A pose as the solver holds it: (qx, qy, qz, qw, tx, ty, tz).
using PoseBlock = std::array<double, 7>;

PoseBlock pose_block(const Pose& pose);
Pose pose_from_block(const double* block);
inline Pose pose_from_block(const PoseBlock& block) {
  return pose_from_block(block.data());
}

/// SE(3) on pose blocks, perturbed in the pose's own frame: T + (rho, phi) = T * (Exp(phi), rho), with rho
/// [m] first and phi [rad] last, as in log_se3. Covariances of the solver are in these six coordinates.
std::unique_ptr<ceres::Manifold> pose_manifold();

}  // namespace uniquadric
