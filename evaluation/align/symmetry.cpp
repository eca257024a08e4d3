#include "evaluation/align/symmetry.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>

namespace uniquadric {
namespace {

// A candidate must beat the identity by this share of the greatest possible agreement, or it is rounding.
constexpr double kRounding = 1e-12;

bool equal_axes(double a, double b) {
  return std::abs(a - b) <= kEqualAxes * std::max(a, b);
}

Eigen::Matrix3d shape_matrix(const Ellipsoid& e) {
  return e.world_from_object.rotation.toRotationMatrix() * e.semi_axes_m.asDiagonal();
}

std::array<Eigen::Matrix3d, 24> make_cube_rotations() {
  std::array<Eigen::Matrix3d, 24> rotations;
  std::size_t count = 0;
  std::array<int, 3> order = {0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      Eigen::Matrix3d P = Eigen::Matrix3d::Zero();
      for (int i = 0; i < 3; ++i) P(order[i], i) = (signs >> i & 1) != 0 ? -1 : 1;
      if (P.determinant() > 0) rotations[count++] = P;
    }
  } while (std::next_permutation(order.begin(), order.end()));
  assert(count == rotations.size());
  return rotations;
}

// Turn about `axis` that makes tr(B^T M) greatest.
Eigen::Matrix3d best_turn(const Eigen::Matrix3d& M, int axis) {
  const int i = (axis + 1) % 3, j = (axis + 2) % 3;
  const double angle = std::atan2(M(j, i) - M(i, j), M(i, i) + M(j, j));
  return Eigen::AngleAxisd(angle, Eigen::Vector3d::Unit(axis)).toRotationMatrix();
}

Eigen::Matrix3d best_rotation(const Eigen::Matrix3d& M) {
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d U = svd.matrixU(), V = svd.matrixV();
  return U * Eigen::Vector3d(1, 1, U.determinant() * V.determinant()).asDiagonal() * V.transpose();
}

std::vector<Eigen::Matrix3d> symmetry_candidates(BodySymmetry symmetry, const Eigen::Vector3d& semi_axes_m,
                                                 int axis, const Eigen::Matrix3d& M) {
  if (symmetry == BodySymmetry::ball) return {best_rotation(M)};
  if (symmetry == BodySymmetry::revolution) {
    const Eigen::Matrix3d flip =
        Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::Unit((axis + 1) % 3)).toRotationMatrix();
    return {best_turn(M, axis), flip * best_turn(flip.transpose() * M, axis)};
  }
  std::vector<Eigen::Matrix3d> kept;
  for (const Eigen::Matrix3d& P : cube_rotations()) {
    const Eigen::Vector3d renamed = P.cwiseAbs().transpose() * semi_axes_m;
    if (equal_axes(renamed.x(), semi_axes_m.x()) && equal_axes(renamed.y(), semi_axes_m.y()) &&
        equal_axes(renamed.z(), semi_axes_m.z()))
      kept.push_back(P);
  }
  return kept;
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

const std::array<Eigen::Matrix3d, 24>& cube_rotations() {
  static const std::array<Eigen::Matrix3d, 24> rotations = make_cube_rotations();
  return rotations;
}

Ellipsoid relabelled(const Ellipsoid& ellipsoid, const Eigen::Matrix3d& axes) {
  if (axes == Eigen::Matrix3d::Identity()) return ellipsoid;
  Ellipsoid result = ellipsoid;
  result.world_from_object.rotation = ellipsoid.world_from_object.rotation * Eigen::Quaterniond(axes);
  result.semi_axes_m = axes.cwiseAbs().transpose() * ellipsoid.semi_axes_m;
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
  for (const Eigen::Matrix3d& P : cube_rotations()) {
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

Eigen::Matrix3d best_symmetry_rotation(BodySymmetry symmetry, const Eigen::Vector3d& true_semi_axes_m,
                                       int axis, const std::vector<Eigen::Matrix3d>& estimate,
                                       const std::vector<Eigen::Matrix3d>& truth) {
  assert(estimate.size() == truth.size());
  Eigen::Matrix3d M = Eigen::Matrix3d::Zero();  // sum |R_e B - R_g|^2 = const - 2 tr(B^T M)
  for (std::size_t i = 0; i < estimate.size(); ++i) M += estimate[i].transpose() * truth[i];
  Eigen::Matrix3d best = Eigen::Matrix3d::Identity();
  double most = M.trace() + kRounding * 3 * static_cast<double>(estimate.size());
  for (const Eigen::Matrix3d& B : symmetry_candidates(symmetry, true_semi_axes_m, axis, M)) {
    const double agreement = B.cwiseProduct(M).sum();
    if (!(agreement > most)) continue;
    most = agreement;
    best = B;
  }
  return best;
}

}  // namespace uniquadric
