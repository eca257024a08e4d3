#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/geometry/ellipsoid.h"

namespace uniquadric {

enum class AxesClass { sphere, spheroid, triaxial };

struct AxesSymmetry {
  AxesClass kind = AxesClass::triaxial;
  int unique_axis = 0;  ///< of a spheroid: the axis that has no equal
};
AxesSymmetry classify_axes(const Eigen::Vector3d& semi_axes_m);

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

}  // namespace uniquadric
