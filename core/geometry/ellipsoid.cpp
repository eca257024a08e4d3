#include "core/geometry/ellipsoid.h"

#include <Eigen/Eigenvalues>
#include <cassert>
#include <cmath>
#include <numbers>

namespace uniquadric {
namespace {

// Semi-axes and angle of the ellipse with centre mu and shape Sigma.
Ellipse ellipse_from_moments(const Eigen::Vector2d& mu, const Eigen::Matrix2d& sigma) {
  // Closed form of the 2x2 symmetric eigenproblem; hypot keeps near-circles exact.
  const double mean = (sigma(0, 0) + sigma(1, 1)) / 2;
  const double half_difference = (sigma(0, 0) - sigma(1, 1)) / 2;
  const double off = sigma(0, 1);
  const double radius = std::hypot(half_difference, off);
  const double major = mean + radius;
  // The smaller eigenvalue as determinant / larger: no cancellation for thin ellipses.
  const double minor = (sigma(0, 0) * sigma(1, 1) - off * off) / major;
  assert(major > 0 && minor > 0);
  double angle = radius > 0 ? 0.5 * std::atan2(off, half_difference) : 0;
  if (angle < 0) angle += std::numbers::pi;
  if (angle >= std::numbers::pi) angle = 0;
  return {mu, std::sqrt(major), std::sqrt(minor), angle};
}

}  // namespace

const char* to_string(ProjectionStatus status) {
  switch (status) {
    case ProjectionStatus::ok:
      return "ok";
    case ProjectionStatus::behind:
      return "behind";
    case ProjectionStatus::not_an_ellipse:
      return "not_an_ellipse";
    case ProjectionStatus::inside:
      return "inside";
  }
  return "";
}

Eigen::Matrix4d object_dual_quadric(const Eigen::Vector3d& semi_axes_m) {
  Eigen::Vector4d diagonal;
  diagonal << semi_axes_m.cwiseAbs2(), -1;
  return diagonal.asDiagonal();
}

Eigen::Matrix4d dual_quadric(const Pose& frame_from_object, const Eigen::Vector3d& semi_axes_m) {
  const Eigen::Matrix4d T = frame_from_object.matrix();
  return T * object_dual_quadric(semi_axes_m) * T.transpose();
}

EllipseProjection project(const Camera& camera, const Pose& camera_from_object,
                          const Eigen::Vector3d& semi_axes_m) {
  const Eigen::Matrix3d R = camera_from_object.rotation.toRotationMatrix();
  const Eigen::Vector3d& t = camera_from_object.translation;
  const Eigen::Vector3d camera_in_unit_ball = (R.transpose() * t).cwiseQuotient(semi_axes_m);
  if (camera_in_unit_ball.squaredNorm() <= 1) return {ProjectionStatus::inside, {}};
  const double half_depth = R.row(2).transpose().cwiseProduct(semi_axes_m).norm();
  if (t.z() <= -half_depth) return {ProjectionStatus::behind, {}};
  if (t.z() <= half_depth) return {ProjectionStatus::not_an_ellipse, {}};

  // C* = M - t t^T in the normalised image plane, M = R diag(a^2) R^T. Its Sigma = C*_{1:2,1:2}/-C*_33 + mu
  // mu^T is written as a sum of squares, since the direct difference loses half the digits for small or
  // distant objects.
  const Eigen::Matrix3d L = R * semi_axes_m.asDiagonal();
  const double scale = (t.z() - half_depth) * (t.z() + half_depth);  // -C*_33 > 0
  const Eigen::Matrix3d M = L * L.transpose();
  const Eigen::Vector2d mu = (t.head<2>() * t.z() - M.topRightCorner<2, 1>()) / scale;
  // With s = t_z^2 - M_33 and m = M_{1:2,3}: s Sigma = M_12 - t t^T + s mu mu^T = rows rows^T - d d^T, where
  // d is what perspective shifts the outline's centre off the projected centre.
  const Eigen::Matrix<double, 2, 3> rows = L.topRows<2>() - mu * L.row(2);
  const Eigen::Vector2d d = t.head<2>() - mu * t.z();
  const Eigen::Matrix2d sigma = (rows * rows.transpose() - d * d.transpose()) / scale;

  const Eigen::DiagonalMatrix<double, 2> F(camera.fx, camera.fy);
  const Eigen::Vector2d center(camera.fx * mu.x() + camera.cx, camera.fy * mu.y() + camera.cy);
  return {ProjectionStatus::ok, ellipse_from_moments(center, F * sigma * F)};
}

Eigen::Matrix2d ellipse_covariance(const Ellipse& ellipse) {
  const Eigen::Rotation2Dd R(ellipse.angle_rad);
  const Eigen::DiagonalMatrix<double, 2> D(ellipse.semi_major * ellipse.semi_major,
                                           ellipse.semi_minor * ellipse.semi_minor);
  return R.toRotationMatrix() * D * R.toRotationMatrix().transpose();
}

Eigen::Matrix3d dual_conic(const Ellipse& ellipse) {
  Eigen::Matrix3d C;
  C.topLeftCorner<2, 2>() = ellipse_covariance(ellipse) - ellipse.center * ellipse.center.transpose();
  C.topRightCorner<2, 1>() = -ellipse.center;
  C.bottomLeftCorner<1, 2>() = -ellipse.center.transpose();
  C(2, 2) = -1;
  return C;
}

Ellipse ellipse_from_dual_conic(const Eigen::Matrix3d& dual_conic) {
  const Eigen::Matrix3d C = dual_conic / -dual_conic(2, 2);
  const Eigen::Vector2d mu = -C.topRightCorner<2, 1>();
  return ellipse_from_moments(mu, C.topLeftCorner<2, 2>() + mu * mu.transpose());
}

}  // namespace uniquadric
