#include "core/geometry/pose.h"

#include <cmath>

namespace uniquadric {
namespace {

constexpr double kSmallAngle = 1e-4;  // rad: below it the series' first dropped term is under 1e-16

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

}  // namespace

Pose Pose::inverse() const {
  const Eigen::Quaterniond back = rotation.conjugate();
  return {back, -(back * translation)};
}

Pose Pose::operator*(const Pose& b) const {
  return {rotation * b.rotation, *this * b.translation};
}

Pose relative_pose(const Pose& world_from_a, const Pose& world_from_b) {
  const Eigen::Quaterniond a_from_world = world_from_a.rotation.conjugate();
  return {a_from_world * world_from_b.rotation,
          a_from_world * (world_from_b.translation - world_from_a.translation)};
}

Eigen::Matrix4d Pose::matrix() const {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() = rotation.toRotationMatrix();
  m.topRightCorner<3, 1>() = translation;
  return m;
}

Eigen::Vector3d log_so3(const Eigen::Quaterniond& q) {
  const double sign = q.w() < 0 ? -1 : 1;  // q and -q are one rotation: take the shorter arc
  const double s = q.vec().norm();
  const double c = sign * q.w();
  const double angle_over_s =
      s < kSmallAngle ? 2 / c - 2 * s * s / (3 * c * c * c) : 2 * std::atan2(s, c) / s;
  return sign * angle_over_s * q.vec();
}

Eigen::Quaterniond exp_so3(const Eigen::Vector3d& rotation_vector) {
  const double angle = rotation_vector.norm();
  const double half_sinc = angle < kSmallAngle ? 0.5 - angle * angle / 48 : std::sin(angle / 2) / angle;
  const Eigen::Vector3d v = half_sinc * rotation_vector;
  return {std::cos(angle / 2), v.x(), v.y(), v.z()};
}

// V maps rho to the translation (Barfoot, State Estimation for Robotics, 2017, Eq. 7.37).
Pose exp_se3(const Vector6d& xi) {
  const Eigen::Vector3d phi = xi.tail<3>();
  const double angle = phi.norm();
  const double a2 = angle * angle;
  const double b = angle < kSmallAngle ? 0.5 - a2 / 24 : 2 * std::pow(std::sin(angle / 2), 2) / a2;
  const double c =
      angle < 1e-2 ? 1.0 / 6 - a2 / 120 + a2 * a2 / 5040 : (angle - std::sin(angle)) / (a2 * angle);
  const Eigen::Matrix3d K = skew(phi);
  return {exp_so3(phi), xi.head<3>() + b * K * xi.head<3>() + c * K * (K * xi.head<3>())};
}

Vector6d log_se3(const Pose& pose) {
  const Eigen::Vector3d phi = log_so3(pose.rotation);
  const double angle = phi.norm();
  const double half = angle / 2;
  const double c =
      angle < 1e-2 ? 1.0 / 12 + angle * angle / 720 : (1 - half / std::tan(half)) / (angle * angle);
  const Eigen::Matrix3d K = skew(phi);
  const Eigen::Vector3d& t = pose.translation;
  Vector6d xi;
  xi << t - 0.5 * K * t + c * K * (K * t), phi;
  return xi;
}

Pose interpolate(const Pose& a, const Pose& b, double u) {
  const Eigen::Vector3d turn = log_so3(a.rotation.conjugate() * b.rotation);
  return {a.rotation * exp_so3(u * turn), a.translation + u * (b.translation - a.translation)};
}

double rotation_angle(const Eigen::Matrix3d& R) {
  const Eigen::Vector3d v(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));
  return std::atan2(v.norm() / 2, (R.trace() - 1) / 2);
}

}  // namespace uniquadric
