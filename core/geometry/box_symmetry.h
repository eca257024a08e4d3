#pragma once

#include <Eigen/Core>
#include <array>

#include "core/geometry/ellipsoid.h"

namespace uniquadric {

/// The 24 rotations that map the axes of a box onto its axes: the signed permutation matrices of determinant
/// +1. The identity comes first; the order is fixed.
const std::array<Eigen::Matrix3d, 24>& box_rotations();

/// The box rotation P of the 24 for which R P is nearest to `reference`, that is for which the angle between
/// the two is least. Of equal ones the first in order.
Eigen::Matrix3d nearest_box_rotation(const Eigen::Matrix3d& R, const Eigen::Matrix3d& reference);

/// The same body with its axes renamed: rotation R P, semi-axes |P^T| a. `P` is one of the 24; the identity
/// changes no digit.
Ellipsoid relabel_axes(const Ellipsoid& ellipsoid, const Eigen::Matrix3d& P);

}  // namespace uniquadric
