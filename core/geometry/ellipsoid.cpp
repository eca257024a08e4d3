#include "core/geometry/ellipsoid.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

namespace uniquadric {
namespace {

// Semi-axes and angle of the ellipse with centre mu, shape Sigma and det Sigma.
Ellipse ellipse_from_moments(const Eigen::Vector2d& mu, const Eigen::Matrix2d& sigma, double determinant) {
  // Closed form of the 2x2 symmetric eigenproblem; hypot keeps near-circles exact.
  const double mean = (sigma(0, 0) + sigma(1, 1)) / 2;
  const double half_difference = (sigma(0, 0) - sigma(1, 1)) / 2;
  const double off = sigma(0, 1);
  const double radius = std::hypot(half_difference, off);
  const double major = mean + radius;
  // The smaller eigenvalue as determinant / larger: as good as the determinant, where mean - radius would
  // cancel once more. Of equal ones rounding may not make the smaller the larger.
  const double minor = std::min(determinant / major, major);
  assert(major > 0 && minor > 0);
  double angle = radius > 0 ? 0.5 * std::atan2(off, half_difference) : 0;
  if (angle < 0) angle += std::numbers::pi;
  if (angle >= std::numbers::pi) angle = 0;
  return {mu, std::sqrt(major), std::sqrt(minor), angle};
}

using Matrix23d = Eigen::Matrix<double, 2, 3>;

// G of Sigma = G G^T in the normalised image plane. C* = L L^T - t t^T stays the same when L = R diag(a) is
// turned from the right until its last row is (0, 0, h). With its upper rows [A b] then
//   Sigma = C*_{1:2,1:2} / s + mu mu^T = (A A^T + (b t_z - t h)(b t_z - t h)^T / s) / s,  s = t_z^2 - h^2,
// a sum of squares, where the difference of the two terms loses half the digits of small, distant or thin
// bodies.
Matrix23d outline_factor(const Eigen::Matrix3d& L, const Eigen::Vector3d& t, double s) {
  // Householder: the reflection along v carries the last row to (0, 0, h); its sign avoids cancellation.
  Eigen::Vector3d v = L.row(2);
  const double h = std::copysign(v.norm(), -v.z());
  v.z() -= h;
  Matrix23d G = L.topRows<2>();
  G -= (G * v) * (2 / v.squaredNorm()) * v.transpose();
  G.col(2) = (G.col(2) * t.z() - t.head<2>() * h) / std::sqrt(s);
  return G / std::sqrt(s);
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

  const Eigen::Matrix3d L = R * semi_axes_m.asDiagonal();
  const double scale = (t.z() - half_depth) * (t.z() + half_depth);  // -C*_33 > 0
  const Eigen::Vector2d mu = (t.head<2>() * t.z() - L.topRows<2>() * L.row(2).transpose()) / scale;
  const Eigen::DiagonalMatrix<double, 2> F(camera.fx, camera.fy);
  const Eigen::Vector2d center(camera.fx * mu.x() + camera.cx, camera.fy * mu.y() + camera.cy);
  const Matrix23d G = F * outline_factor(L, t, scale);
  // det G G^T (Cauchy-Binet), which keeps twice the digits that the determinant of the product does.
  const double determinant = Eigen::Vector3d(G.row(0)).cross(Eigen::Vector3d(G.row(1))).squaredNorm();
  if (!(determinant > 0)) return {ProjectionStatus::not_an_ellipse, {}};
  return {ProjectionStatus::ok, ellipse_from_moments(center, G * G.transpose(), determinant)};
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
  const Eigen::Matrix2d sigma = C.topLeftCorner<2, 2>() + mu * mu.transpose();
  return ellipse_from_moments(mu, sigma, sigma(0, 0) * sigma(1, 1) - sigma(0, 1) * sigma(1, 0));
}

}  // namespace uniquadric
