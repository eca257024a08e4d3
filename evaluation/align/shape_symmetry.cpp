#include "evaluation/align/shape_symmetry.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cassert>
#include <numbers>

#include "core/geometry/box_symmetry.h"
#include "evaluation/align/symmetry.h"

namespace uniquadric {
namespace {

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

std::vector<Eigen::Matrix3d> box_symmetries(const Eigen::Vector3d& semi_axes_m) {
  std::vector<Eigen::Matrix3d> kept;
  for (const Eigen::Matrix3d& P : box_rotations()) {
    const Eigen::Vector3d renamed = P.cwiseAbs().transpose() * semi_axes_m;
    bool same = true;
    for (int i = 0; i < 3; ++i) same = same && equal_axes(renamed[i], semi_axes_m[i]);
    if (same) kept.push_back(P);
  }
  return kept;
}

std::vector<Eigen::Matrix3d> symmetry_candidates(const ShapeSymmetry& symmetry,
                                                 const Eigen::Vector3d& semi_axes_m,
                                                 const Eigen::Matrix3d& M) {
  switch (symmetry.kind) {
    case BodySymmetry::box:
      return box_symmetries(semi_axes_m);
    case BodySymmetry::revolution: {
      const Eigen::Matrix3d flip =
          Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::Unit((symmetry.axis + 1) % 3))
              .toRotationMatrix();
      return {best_turn(M, symmetry.axis), flip * best_turn(flip.transpose() * M, symmetry.axis)};
    }
    case BodySymmetry::sphere:
      return {best_rotation(M)};
    case BodySymmetry::none:
      return {};
  }
  return {};
}

// A candidate must beat the identity by this share of the greatest possible agreement, or it is rounding.
constexpr double kRounding = 1e-12;

Eigen::Matrix3d fit_symmetry(const ShapeSymmetry& symmetry, const std::vector<Ellipsoid>& estimate,
                             const std::vector<Ellipsoid>& truth) {
  const std::size_t count =
      symmetry.kind == BodySymmetry::box ? truth.size() : std::min(truth.size(), kFitFrames);
  std::vector<Eigen::Matrix3d> from, to;
  for (std::size_t i = 0; i < count; ++i) {
    from.push_back(estimate[i].world_from_object.rotation.toRotationMatrix());
    to.push_back(truth[i].world_from_object.rotation.toRotationMatrix());
  }
  return best_symmetry_rotation(symmetry, truth.front().semi_axes_m, from, to);
}

Ellipsoid turned(const Ellipsoid& ellipsoid, const ShapeSymmetry& symmetry, const Eigen::Matrix3d& rotation) {
  if (symmetry.kind == BodySymmetry::box) return relabel_axes(ellipsoid, rotation);
  if (rotation == Eigen::Matrix3d::Identity()) return ellipsoid;
  Ellipsoid result = ellipsoid;  // the semi-axes keep their names: the shape is the same after any such turn
  result.world_from_object.rotation = ellipsoid.world_from_object.rotation * Eigen::Quaterniond(rotation);
  return result;
}

}  // namespace

ShapeSymmetry shape_symmetry(const std::string& shape, const std::optional<BodySymmetry>& stated,
                             const Eigen::Vector3d& semi_axes_m) {
  const auto axis = revolution_axis(semi_axes_m);
  if (stated) return {*stated, axis.value_or(2)};
  if (shape == "cylinder" && equal_axes(semi_axes_m.x(), semi_axes_m.y()))
    return {BodySymmetry::revolution, 2};
  if (shape != "ball" && shape != "ellipsoid") return {};
  if (allows(semi_axes_m, BodySymmetry::sphere)) return {BodySymmetry::sphere, 2};
  return axis ? ShapeSymmetry{BodySymmetry::revolution, *axis} : ShapeSymmetry{};
}

Eigen::Matrix3d best_symmetry_rotation(const ShapeSymmetry& symmetry, const Eigen::Vector3d& true_semi_axes_m,
                                       const std::vector<Eigen::Matrix3d>& estimate,
                                       const std::vector<Eigen::Matrix3d>& truth) {
  assert(estimate.size() == truth.size());
  Eigen::Matrix3d M = Eigen::Matrix3d::Zero();  // sum |R_e B - R_g|^2 = const - 2 tr(B^T M)
  for (std::size_t i = 0; i < estimate.size(); ++i) M += estimate[i].transpose() * truth[i];
  Eigen::Matrix3d best = Eigen::Matrix3d::Identity();
  double most = M.trace() + kRounding * 3 * static_cast<double>(estimate.size());
  for (const Eigen::Matrix3d& B : symmetry_candidates(symmetry, true_semi_axes_m, M)) {
    const double agreement = B.cwiseProduct(M).sum();
    if (!(agreement > most)) continue;
    most = agreement;
    best = B;
  }
  return best;
}

SettledTrack settle_axes(const ShapeSymmetry& symmetry, const std::vector<Ellipsoid>& estimate,
                         const std::vector<Ellipsoid>& truth) {
  assert(estimate.size() == truth.size());
  if (truth.empty() || symmetry.kind == BodySymmetry::none) return {estimate, 0};
  SettledTrack settled;
  const Eigen::Matrix3d names = best_relabelling(estimate, truth);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    settled.relabel_flips += best_relabelling({estimate[i]}, {truth[i]}) != names ? 1 : 0;
    settled.estimate.push_back(relabel_axes(estimate[i], names));
  }
  const Eigen::Matrix3d rotation = fit_symmetry(symmetry, settled.estimate, truth);
  for (Ellipsoid& ellipsoid : settled.estimate) ellipsoid = turned(ellipsoid, symmetry, rotation);
  return settled;
}

}  // namespace uniquadric
