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

Eigen::Matrix3d end_for_end(int axis) {
  return Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::Unit((axis + 1) % 3)).toRotationMatrix();
}

std::vector<Eigen::Matrix3d> symmetry_candidates(const ShapeSymmetry& symmetry,
                                                 const Eigen::Vector3d& semi_axes_m,
                                                 const Eigen::Matrix3d& M) {
  switch (symmetry.kind) {
    case BodySymmetry::box:
      return box_symmetries(semi_axes_m);
    case BodySymmetry::revolution: {
      const Eigen::Matrix3d flip = end_for_end(symmetry.axis);
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

// The pairs of one stretch.
struct Stretch {
  std::vector<Ellipsoid> estimate, truth;
  bool is_long() const { return truth.size() >= kFitFrames; }
};

std::vector<Stretch> cut(const std::vector<Ellipsoid>& estimate, const std::vector<Ellipsoid>& truth,
                         const std::vector<std::size_t>& later_starts) {
  std::vector<std::size_t> bounds = {0};
  bounds.insert(bounds.end(), later_starts.begin(), later_starts.end());
  bounds.push_back(truth.size());
  std::vector<Stretch> stretches;
  for (std::size_t i = 0; i + 1 < bounds.size(); ++i) {
    const auto first = static_cast<std::ptrdiff_t>(bounds[i]);
    const auto end = static_cast<std::ptrdiff_t>(bounds[i + 1]);
    assert(first < end && bounds[i + 1] <= truth.size());
    stretches.push_back(
        {{estimate.begin() + first, estimate.begin() + end}, {truth.begin() + first, truth.begin() + end}});
  }
  return stretches;
}

// The change that suits these pairs by themselves.
AxesChange own_change(const ShapeSymmetry& symmetry, const std::vector<Ellipsoid>& estimate,
                      const std::vector<Ellipsoid>& truth) {
  AxesChange change{best_relabelling(estimate, truth), Eigen::Matrix3d::Identity()};
  std::vector<Ellipsoid> named;
  for (const Ellipsoid& ellipsoid : estimate) named.push_back(relabel_axes(ellipsoid, change.names));
  const Eigen::Matrix3d rotation = fit_symmetry(symmetry, named, truth);
  if (symmetry.kind == BodySymmetry::box)
    change.names = change.names * rotation;
  else
    change.turn = rotation;
  return change;
}

// `known` with the unique axis turned end for end where that brings it nearer to the true one.
AxesChange with_better_end(const AxesChange& known, int axis, const Stretch& stretch) {
  double agreement = 0;  // sum of the cosines between the two unique axes
  for (std::size_t i = 0; i < stretch.truth.size(); ++i) {
    const Pose settled = changed_axes(stretch.estimate[i], known).world_from_object;
    const Eigen::Vector3d unit = Eigen::Vector3d::Unit(axis);
    agreement += (settled.rotation * unit).dot(stretch.truth[i].world_from_object.rotation * unit);
  }
  return agreement < 0 ? AxesChange{known.names, end_for_end(axis) * known.turn} : known;
}

// What short stretches take names and turn from, a stretch an entry.
std::vector<AxesChange> known_changes(const ShapeSymmetry& symmetry, const std::vector<Stretch>& stretches,
                                      const std::vector<Ellipsoid>& estimate,
                                      const std::vector<Ellipsoid>& truth) {
  const auto first_long = std::ranges::find_if(stretches, &Stretch::is_long);
  AxesChange known = first_long == stretches.end()
                         ? own_change(symmetry, estimate, truth)
                         : own_change(symmetry, first_long->estimate, first_long->truth);
  std::vector<AxesChange> changes;
  for (const Stretch& stretch : stretches) {
    if (stretch.is_long()) known = own_change(symmetry, stretch.estimate, stretch.truth);
    changes.push_back(known);
  }
  return changes;
}

std::vector<AxesChange> stretch_changes(const ShapeSymmetry& symmetry, const std::vector<Stretch>& stretches,
                                        const std::vector<Ellipsoid>& estimate,
                                        const std::vector<Ellipsoid>& truth) {
  std::vector<AxesChange> changes;
  if (symmetry.kind == BodySymmetry::box) {
    for (const Stretch& stretch : stretches)
      changes.push_back(own_change(symmetry, stretch.estimate, stretch.truth));
    return changes;
  }
  changes = known_changes(symmetry, stretches, estimate, truth);
  for (std::size_t i = 0; i < stretches.size() && symmetry.kind == BodySymmetry::revolution; ++i)
    if (!stretches[i].is_long()) changes[i] = with_better_end(changes[i], symmetry.axis, stretches[i]);
  return changes;
}

int relabel_flips(const Stretch& stretch) {
  const Eigen::Matrix3d names = best_relabelling(stretch.estimate, stretch.truth);
  int flips = 0;
  for (std::size_t i = 0; i < stretch.truth.size(); ++i)
    flips += best_relabelling({stretch.estimate[i]}, {stretch.truth[i]}) != names ? 1 : 0;
  return flips;
}

}  // namespace

ShapeSymmetry shape_symmetry(const std::string& shape, const std::optional<BodySymmetry>& stated,
                             const Eigen::Vector3d& semi_axes_m) {
  const auto axis = revolution_axis(semi_axes_m);
  if (stated) return {*stated, axis.value_or(2)};
  if ((shape == "cylinder" || shape == "bowl") && equal_axes(semi_axes_m.x(), semi_axes_m.y()))
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

Ellipsoid changed_axes(const Ellipsoid& ellipsoid, const AxesChange& change) {
  Ellipsoid result = relabel_axes(ellipsoid, change.names);
  if (change.turn == Eigen::Matrix3d::Identity()) return result;
  result.world_from_object.rotation = result.world_from_object.rotation * Eigen::Quaterniond(change.turn);
  return result;
}

SettledTrack settle_axes(const ShapeSymmetry& symmetry, const std::vector<Ellipsoid>& estimate,
                         const std::vector<Ellipsoid>& truth, const std::vector<std::size_t>& later_starts) {
  assert(estimate.size() == truth.size());
  if (truth.empty() || symmetry.kind == BodySymmetry::none)
    return {estimate, std::vector<AxesChange>(truth.size()), 0};
  SettledTrack settled;
  const std::vector<Stretch> stretches = cut(estimate, truth, later_starts);
  const std::vector<AxesChange> changes = stretch_changes(symmetry, stretches, estimate, truth);
  for (std::size_t i = 0; i < stretches.size(); ++i) {
    settled.relabel_flips += relabel_flips(stretches[i]);
    for (const Ellipsoid& ellipsoid : stretches[i].estimate) {
      settled.estimate.push_back(changed_axes(ellipsoid, changes[i]));
      settled.changes.push_back(changes[i]);
    }
  }
  return settled;
}

}  // namespace uniquadric
