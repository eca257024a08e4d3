#pragma once

#include <Eigen/Core>
#include <array>

#include "core/geometry/superquadric.h"

namespace uniquadric {

/// Semi-axes as the solver holds them: (ln a_x, ln a_y, ln a_z), a in metres, so that they stay positive.
using AxesBlock = std::array<double, 3>;
AxesBlock axes_block(const Eigen::Vector3d& semi_axes_m);
Eigen::Vector3d axes_from_block(const double* block);

/// An exponent q of a superellipsoid in [1, 2] as the solver holds it: s with q = 1 + 1 / (1 + exp(-s)). A
/// body has a block of one (all its exponents equal) or of three (outline, upper, lower). q = 2 becomes s =
/// 40, whose q is 2 to the last bit and does not move: the quadric. To estimate q, start at 1.3
/// (docs/shape.md).
double exponent_block(double q);
double exponent_from_block(double s);
/// d q / d s.
double exponent_slope(double s);

/// The exponents of a block of `count` = 1 or 3.
SuperExponents exponents_from_block(const double* block, int count);

}  // namespace uniquadric
