#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace uniquadric {

using Vector6d = Eigen::Matrix<double, 6, 1>;

/// A rigid transform a_from_b: p_in_a = a_from_b * p_in_b. The rotation is a unit quaternion; it is kept as
/// given (never re-normalised here), so that a written trajectory reads back as the same doubles.
struct Pose {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();  ///< [m]

  Pose inverse() const;
  Pose operator*(const Pose& b) const;
  Eigen::Vector3d operator*(const Eigen::Vector3d& p) const { return rotation * p + translation; }
  Eigen::Matrix4d matrix() const;
};

/// a_from_b of two poses in one world. The positions are subtracted before they are turned, so that far from
/// the world's origin no digits are lost, as they are in `world_from_a.inverse() * world_from_b`.
Pose relative_pose(const Pose& world_from_a, const Pose& world_from_b);

/// Rotation vector [rad] of R; the angle is in [0, pi].
Eigen::Vector3d log_so3(const Eigen::Quaterniond& q);
Eigen::Quaterniond exp_so3(const Eigen::Vector3d& rotation_vector);

/// se(3) logarithm (rho; phi): translation part [m] first, then rotation vector [rad].
Vector6d log_se3(const Pose& pose);
Pose exp_se3(const Vector6d& xi);

/// Pose at fraction u of the way from a to b: slerp of the relative rotation along the shortest arc,
/// constant-velocity translation (Eq. 3; the paper slerps two world orientations and applies the first one
/// twice; we take the relative rotation). u outside [0, 1] extrapolates at constant velocity.
Pose interpolate(const Pose& a, const Pose& b, double u);

/// Angle of R in [0, pi] rad: atan2(|vee(R - R^T)| / 2, (tr R - 1) / 2). Exactly 0 for a symmetric R near I.
double rotation_angle(const Eigen::Matrix3d& R);

}  // namespace uniquadric
