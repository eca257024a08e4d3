#include "estimator/shape/oriented_box.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

namespace uniquadric {
namespace {

Eigen::Vector3d in_box(const OrientedBox& box, const Eigen::Vector3d& point) {
  return box.axes.transpose() * (point - box.center);
}

}  // namespace

Ellipsoid inscribed_ellipsoid(const OrientedBox& box) {
  return {{Eigen::Quaterniond(box.axes).normalized(), box.center}, box.half_extents_m};
}

OrientedBox relabel_axes(const OrientedBox& box, const Eigen::Matrix3d& P) {
  return {box.center, box.axes * P, P.cwiseAbs().transpose() * box.half_extents_m};
}

double distance_to_surface(const OrientedBox& box, const Eigen::Vector3d& point) {
  const Eigen::Vector3d beyond = in_box(box, point).cwiseAbs() - box.half_extents_m;
  const double nearest_face = beyond.maxCoeff();
  return nearest_face <= 0 ? -nearest_face : beyond.cwiseMax(0.0).norm();
}

double distance_to_corner(const OrientedBox& box, const Eigen::Vector3d& point) {
  return (in_box(box, point) - box.half_extents_m).norm();
}

OrientedBox box_along(const Eigen::Matrix3d& axes, const Eigen::Matrix3Xd& points) {
  const Eigen::Matrix3Xd turned = axes.transpose() * points;
  const Eigen::Vector3d low = turned.rowwise().minCoeff(), high = turned.rowwise().maxCoeff();
  return {axes * (0.5 * (low + high)), axes, 0.5 * (high - low)};
}

std::optional<OrientedBox> fit_pca_box(const Eigen::Matrix3Xd& points) {
  if (points.cols() < 4) return std::nullopt;
  const Eigen::Matrix3Xd centred = points.colwise() - points.rowwise().mean();
  Eigen::Matrix3d axes =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(centred * centred.transpose()).eigenvectors();
  if (axes.determinant() < 0) axes.col(0) = -axes.col(0);
  return box_along(axes, points);
}

}  // namespace uniquadric
