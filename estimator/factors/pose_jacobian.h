#pragma once

// Derivatives on SE(3) that the factors share. A perturbation (rho, phi) of T is T * (Exp(phi), rho).
#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/geometry/pose.h"

namespace uniquadric {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// T * (Exp(phi), rho), its rotation normalised.
Pose perturbed(const Pose& pose, const Vector6d& rho_phi);

Eigen::Matrix3d skew(const Eigen::Vector3d& v);

/// Right Jacobian of SO(3): Exp(phi + d) = Exp(phi) Exp(J d) to first order, and its inverse.
Eigen::Matrix3d right_jacobian_so3(const Eigen::Vector3d& phi);
Eigen::Matrix3d inverse_right_jacobian_so3(const Eigen::Vector3d& phi);

/// Ad_T: T * (Exp(phi), rho) = (Exp(phi'), rho') * T with (rho', phi') = Ad_T (rho, phi) to first order.
Matrix6d adjoint(const Pose& pose);

/// d log_se3(T * (Exp(phi), rho)) / d (rho, phi).
Matrix6d log_se3_jacobian(const Pose& pose);

/// d q / d phi of q * Exp(phi), rows x, y, z, w.
Eigen::Matrix<double, 4, 3> quaternion_tangent(const Eigen::Quaterniond& q);

/// Writes a Jacobian by (rho, phi), `Rows` x 6, as one by the seven numbers of the pose block (row-major),
/// such that the manifold's own Jacobian gives `local` back.
template <int Rows>
void write_pose_jacobian(const Eigen::Matrix<double, Rows, 6>& local, const Eigen::Quaterniond& q,
                         double* block_jacobian) {
  Eigen::Map<Eigen::Matrix<double, Rows, 7, Eigen::RowMajor>> out(block_jacobian);
  out.template leftCols<4>().noalias() =
      local.template rightCols<3>() * (4 * quaternion_tangent(q).transpose());
  out.template rightCols<3>().noalias() = local.template leftCols<3>() * q.toRotationMatrix().transpose();
}

}  // namespace uniquadric
