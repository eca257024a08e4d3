#pragma once

#include <Eigen/Core>

namespace uniquadric {

/// Support function of the superellipsoid sum |x_i / a_i|^p <= 1: h(n) = ||a o n||_q with 1/p + 1/q = 1 and q
/// in (1, 2]; q = 2 is the ellipsoid, q -> 1 the box. `n` need not be a unit vector: h is homogeneous of
/// degree 1. `smoothing_m` > 0 replaces |x| by sqrt(x^2 + smoothing^2) - smoothing, so that h has derivatives
/// everywhere. Differentiable type T: double or a jet.
template <typename T>
T superellipsoid_support(const Eigen::Matrix<T, 3, 1>& semi_axes_m, const T& q,
                         const Eigen::Matrix<T, 3, 1>& normal, double smoothing_m = 0);

/// The point of the superellipsoid that supports `normal` (q > 1): grad h, which satisfies h(n) = n . x.
Eigen::Vector3d superellipsoid_support_point(const Eigen::Vector3d& semi_axes_m, double q,
                                             const Eigen::Vector3d& normal);

/// Volume of the superellipsoid of dual exponent q (closed form by gamma functions) [m^3]; q = 1 gives the
/// box.
double superellipsoid_volume(const Eigen::Vector3d& semi_axes_m, double q);

}  // namespace uniquadric

#include "core/geometry/superquadric_impl.h"
