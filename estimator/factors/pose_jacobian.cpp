#include "estimator/factors/pose_jacobian.h"

#include <cmath>

namespace uniquadric {
namespace {

constexpr double kSeriesAngle = 1e-2;  // rad: below it the series' first dropped term is under 1e-12

// c of log_se3, V^-1 = I - K / 2 + c K^2 with K = skew(phi), and c'(angle) / angle.
struct LogCoefficient {
  double c, slope_over_angle;
};

LogCoefficient log_coefficient(double angle) {
  const double a2 = angle * angle;
  if (angle < kSeriesAngle) return {1.0 / 12 + a2 / 720 + a2 * a2 / 30240, 1.0 / 360 + a2 / 7560};
  const double half = angle / 2, cotangent = 1 / std::tan(half), sine = std::sin(half);
  const double c = (1 - half * cotangent) / a2;
  // d(half cot half) / d angle = (cot half - half / sin^2 half) / 2
  return {c, -(cotangent - half / (sine * sine)) / (2 * a2 * angle) - 2 * c / a2};
}

}  // namespace

Pose perturbed(const Pose& pose, const Vector6d& rho_phi) {
  Pose result = pose * Pose{exp_so3(rho_phi.tail<3>()), rho_phi.head<3>()};
  result.rotation.normalize();
  return result;
}

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

Eigen::Matrix3d right_jacobian_so3(const Eigen::Vector3d& phi) {
  const double angle = phi.norm(), a2 = angle * angle;
  const double half_sine = std::sin(angle / 2);
  const double b = angle < kSeriesAngle ? 0.5 - a2 / 24 + a2 * a2 / 720 : 2 * half_sine * half_sine / a2;
  const double c =
      angle < kSeriesAngle ? 1.0 / 6 - a2 / 120 + a2 * a2 / 5040 : (angle - std::sin(angle)) / (a2 * angle);
  const Eigen::Matrix3d K = skew(phi);
  return Eigen::Matrix3d::Identity() - b * K + c * K * K;
}

Eigen::Matrix3d inverse_right_jacobian_so3(const Eigen::Vector3d& phi) {
  const Eigen::Matrix3d K = skew(phi);
  return Eigen::Matrix3d::Identity() + 0.5 * K + log_coefficient(phi.norm()).c * K * K;
}

Matrix6d adjoint(const Pose& pose) {
  const Eigen::Matrix3d R = pose.rotation.toRotationMatrix();
  Matrix6d ad = Matrix6d::Zero();
  ad.topLeftCorner<3, 3>() = R;
  ad.topRightCorner<3, 3>() = skew(pose.translation) * R;
  ad.bottomRightCorner<3, 3>() = R;
  return ad;
}

// rho = V^-1(phi) t with V^-1 t = t - phi x t / 2 + c phi x (phi x t).
Matrix6d log_se3_jacobian(const Pose& pose) {
  const Eigen::Vector3d phi = log_so3(pose.rotation), &t = pose.translation;
  const LogCoefficient k = log_coefficient(phi.norm());
  const Eigen::Matrix3d K = skew(phi), I = Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d inverse_right = I + 0.5 * K + k.c * K * K;
  const Eigen::Matrix3d rho_by_phi = 0.5 * skew(t) +
                                     k.c * (phi.dot(t) * I + phi * t.transpose() - 2 * t * phi.transpose()) +
                                     k.slope_over_angle * (phi.cross(phi.cross(t))) * phi.transpose();
  Matrix6d J = Matrix6d::Zero();
  J.topLeftCorner<3, 3>() = (I - 0.5 * K + k.c * K * K) * pose.rotation.toRotationMatrix();
  J.topRightCorner<3, 3>() = rho_by_phi * inverse_right;
  J.bottomRightCorner<3, 3>() = inverse_right;
  return J;
}

Eigen::Matrix<double, 4, 3> quaternion_tangent(const Eigen::Quaterniond& q) {
  Eigen::Matrix<double, 4, 3> E;
  E.topRows<3>() = 0.5 * (q.w() * Eigen::Matrix3d::Identity() + skew(q.vec()));
  E.bottomRows<1>() = -0.5 * q.vec().transpose();
  return E;
}

}  // namespace uniquadric
