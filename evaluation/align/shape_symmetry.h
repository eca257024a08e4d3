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
/// ellipsoids are spheres, of revolution, or box-like as their axes say; a cylinder is of revolution about z
/// when it is round; everything else is box-like, with the box rotations that its semi-axes allow.
ShapeSymmetry shape_symmetry(const std::string& shape, const std::optional<BodySymmetry>& stated,
                             const Eigen::Vector3d& semi_axes_m);

/// Rotation B of the body frame, taken from the true shape's symmetries, that brings R_e B nearest to R_g
/// over the pairs (chordal distance). The identity unless another one is better by more than rounding.
Eigen::Matrix3d best_symmetry_rotation(const ShapeSymmetry& symmetry, const Eigen::Vector3d& true_semi_axes_m,
                                       const std::vector<Eigen::Matrix3d>& estimate,
                                       const std::vector<Eigen::Matrix3d>& truth);

/// Matched frames whose own naming of the axes would settle a free rotation: SPEC 6 fits it on the first 10.
inline constexpr std::size_t kFitFrames = 10;

/// A track's matched ellipsoids after one body-frame rotation for the whole track (SPEC 6, APE.r).
struct SettledTrack {
  std::vector<Ellipsoid> estimate;
  int relabel_flips = 0;  ///< frames that by themselves would name the axes otherwise
};

/// First the estimate's axes get the names that suit the truth best over all pairs (best_relabelling), then
/// the body frame is turned by best_symmetry_rotation: box rotations over all pairs, free ones over the first
/// kFitFrames. A shape without symmetry (`none`) keeps frame and names as they came. Lists in pairs.
SettledTrack settle_axes(const ShapeSymmetry& symmetry, const std::vector<Ellipsoid>& estimate,
                         const std::vector<Ellipsoid>& truth);

}  // namespace uniquadric
