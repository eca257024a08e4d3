#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/geometry/body_symmetry.h"
#include "core/geometry/ellipsoid.h"

namespace uniquadric {

/// A true shape's symmetry and, for `revolution`, its axis (0 to 2).
struct ShapeSymmetry {
  BodySymmetry kind = BodySymmetry::box;
  int axis = 2;
};

/// What the truth says (`stated`), else by kind of mesh (objects.yaml's `shape`) and semi-axes: balls and
/// ellipsoids are spheres, of revolution, or box-like as their axes say; a cylinder or bowl is of revolution
/// about z when it is round; everything else is box-like, with the box rotations that its semi-axes allow.
ShapeSymmetry shape_symmetry(const std::string& shape, const std::optional<BodySymmetry>& stated,
                             const Eigen::Vector3d& semi_axes_m);

/// Rotation B of the body frame, taken from the true shape's symmetries, that brings R_e B nearest to R_g
/// over the pairs (chordal distance). The identity unless another one is better by more than rounding.
Eigen::Matrix3d best_symmetry_rotation(const ShapeSymmetry& symmetry, const Eigen::Vector3d& true_semi_axes_m,
                                       const std::vector<Eigen::Matrix3d>& estimate,
                                       const std::vector<Eigen::Matrix3d>& truth);

/// Matched frames on which a free rotation is fitted: SPEC 6 takes the first 10.
inline constexpr std::size_t kFitFrames = 10;

/// How the axes of an estimate are named anew: `names`, one of the 24 box rotations, takes the semi-axes
/// along; `turn`, a rotation that the true shape leaves open, keeps them.
struct AxesChange {
  Eigen::Matrix3d names = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
};
/// The same estimate with that change. The identity changes no digit.
Ellipsoid changed_axes(const Ellipsoid& ellipsoid, const AxesChange& change);

/// A track's matched ellipsoids after one body-frame rotation a stretch (SPEC 6, APE.r).
struct SettledTrack {
  std::vector<Ellipsoid> estimate;
  std::vector<AxesChange> changes;  ///< of each pair; the same throughout a stretch
  int relabel_flips = 0;            ///< frames that by themselves would name the axes otherwise
};

/// Settles each stretch of the track by itself. `later_starts` holds the first pair of each stretch but the
/// first, in order (stretches.h); without any the whole track is one stretch. Lists in pairs.
///
/// A stretch's axes get the names that suit the truth best over its pairs (best_relabelling). Then
/// best_symmetry_rotation turns its body frame: box rotations over all its pairs, free ones over the first
/// kFitFrames. A shape without symmetry (`none`) keeps frame and names as they came.
///
/// A stretch of fewer than kFitFrames pairs fits no free rotation. It takes names and turn from the last
/// longer stretch before it, else from the first after it. A track without any is fitted as one stretch.
/// A short stretch of a body of revolution settles only which way its unique axis points.
SettledTrack settle_axes(const ShapeSymmetry& symmetry, const std::vector<Ellipsoid>& estimate,
                         const std::vector<Ellipsoid>& truth,
                         const std::vector<std::size_t>& later_starts = {});

}  // namespace uniquadric
