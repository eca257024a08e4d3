#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "core/geometry/ellipsoid.h"

namespace uniquadric {

/// Semi-axes that differ by no more than this share of the larger count as equal (SPEC: 5 %).
inline constexpr double kEqualAxes = 0.05;

enum class AxesClass { sphere, spheroid, triaxial };

struct AxesSymmetry {
  AxesClass kind = AxesClass::triaxial;
  int unique_axis = 0;  ///< of a spheroid: the axis that has no equal
};
AxesSymmetry classify_axes(const Eigen::Vector3d& semi_axes_m);

/// The 24 proper rotations of the cube, the identity first: signed permutation matrices of determinant 1.
const std::array<Eigen::Matrix3d, 24>& cube_rotations();

/// The same ellipsoid with its axes named anew: R -> R P, a -> |P|^T a, P one of cube_rotations().
Ellipsoid relabelled(const Ellipsoid& ellipsoid, const Eigen::Matrix3d& axes);

/// The renaming of the estimate's axes that suits the truth best over all pairs:
/// argmin_P sum |R_e P diag(|P|^T a_e) - R_g diag(a_g)|_F^2. The identity wins ties. `estimate` and `truth`
/// in pairs.
Eigen::Matrix3d best_relabelling(const std::vector<Ellipsoid>& estimate, const std::vector<Ellipsoid>& truth);

/// Rotation error of an estimate, its axes relabelled before, by the class of the true semi-axes: nothing for
/// a sphere, the angle between the unique axes' lines for a spheroid, the least over the four flips (turns by
/// pi about an axis) for three different axes [rad].
std::optional<double> symmetric_rotation_error(const Ellipsoid& estimate, const Ellipsoid& truth);

/// Distance of two ellipsoids in metres that needs neither axes' names nor thresholds: sqrt(|dc|^2 + BW^2 /
/// 3) with BW^2 = |L_g|^2 + |L_e|^2 - 2 |L_g^T L_e|_*, L = R diag(a) and the nuclear norm
/// (Bures-Wasserstein).
double shape_distance_m(const Ellipsoid& estimate, const Ellipsoid& truth);

/// What a body's own shape leaves open about its orientation.
enum class BodySymmetry {
  box,         ///< the cube rotations that keep the true semi-axes within 5 %
  revolution,  ///< any turn about one axis, and its flip
  ball,        ///< any rotation
};

/// Rotation B of the body frame, taken from the true shape's symmetries, that brings R_e B nearest to R_g
/// over the pairs (chordal distance). The identity unless another one is better by more than rounding. `axis`
/// is the axis of revolution.
Eigen::Matrix3d best_symmetry_rotation(BodySymmetry symmetry, const Eigen::Vector3d& true_semi_axes_m,
                                       int axis, const std::vector<Eigen::Matrix3d>& estimate,
                                       const std::vector<Eigen::Matrix3d>& truth);

}  // namespace uniquadric
