#include "evaluation/align/symmetry.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>

#include "core/geometry/body_symmetry.h"
#include "core/geometry/box_symmetry.h"

namespace uniquadric {
namespace {

// A candidate must beat the identity by this share of the greatest possible agreement, or it is rounding.
constexpr double kRounding = 1e-12;

Eigen::Matrix3d shape_matrix(const Ellipsoid& e) {
  return e.world_from_object.rotation.toRotationMatrix() * e.semi_axes_m.asDiagonal();
}

}  // namespace

AxesSymmetry classify_axes(const Eigen::Vector3d& a) {
  const bool xy = equal_axes(a.x(), a.y()), yz = equal_axes(a.y(), a.z()), zx = equal_axes(a.z(), a.x());
  if (xy && yz && zx) return {AxesClass::sphere, 0};
  // Of two pairs within the tolerance the closer one makes the spheroid.
  const std::array<bool, 3> others_equal = {yz, zx, xy};
  AxesSymmetry result;
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    const double difference = std::abs(a[(i + 1) % 3] - a[(i + 2) % 3]);
    if (!others_equal[i] || !(difference < least)) continue;
    least = difference;
    result = {AxesClass::spheroid, i};
  }
  return result;
}

Eigen::Matrix3d best_relabelling(const std::vector<Ellipsoid>& estimate,
                                 const std::vector<Ellipsoid>& truth) {
  assert(estimate.size() == truth.size());
  // |L_e P - L_g|^2 = |L_e|^2 + |L_g|^2 - 2 tr(L_g^T L_e P), since P diag(|P|^T a) = diag(a) P.
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < estimate.size(); ++i)
    sum += shape_matrix(truth[i]).transpose() * shape_matrix(estimate[i]);
  Eigen::Matrix3d best = Eigen::Matrix3d::Identity();
  double most = sum.trace() + kRounding * sum.norm();
  for (const Eigen::Matrix3d& P : box_rotations()) {
    const double agreement = (sum * P).trace();
    if (!(agreement > most)) continue;
    most = agreement;
    best = P;
  }
  return best;
}

std::optional<double> symmetric_rotation_error(const Ellipsoid& estimate, const Ellipsoid& truth) {
  const Eigen::Matrix3d R = estimate.world_from_object.rotation.toRotationMatrix().transpose() *
                            truth.world_from_object.rotation.toRotationMatrix();
  const AxesSymmetry symmetry = classify_axes(truth.semi_axes_m);
  if (symmetry.kind == AxesClass::sphere) return std::nullopt;
  if (symmetry.kind == AxesClass::spheroid) {
    const int k = symmetry.unique_axis;  // sine from the off-axis parts: exact for small angles
    return std::atan2(std::hypot(R((k + 1) % 3, k), R((k + 2) % 3, k)), std::abs(R(k, k)));
  }
  double least = rotation_angle(R);
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::Vector3d flip = -Eigen::Vector3d::Ones();
    flip[axis] = 1;
    least = std::min(least, rotation_angle(R * flip.asDiagonal()));
  }
  return least;
}

double shape_distance_m(const Ellipsoid& estimate, const Ellipsoid& truth) {
  const Eigen::Matrix3d Le = shape_matrix(estimate), Lg = shape_matrix(truth);
  const Eigen::Vector3d between =
      estimate.world_from_object.translation - truth.world_from_object.translation;
  if (Le == Lg) return between.norm();
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(Lg.transpose() * Le, Eigen::ComputeFullU | Eigen::ComputeFullV);
  // |L_g|^2 + |L_e|^2 - 2 tr(S) = |L_g U - L_e V|^2 (U, V the singular vectors): no cancellation.
  const double squared = (Lg * svd.matrixU() - Le * svd.matrixV()).squaredNorm();
  return std::sqrt(between.squaredNorm() + squared / 3);
}

}  // namespace uniquadric
