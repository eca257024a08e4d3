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

/// Exponents of a superellipsoid that need not be symmetric about its plane z = 0, each in [1, 2]: of its
/// outline in (x, y), and of its profile above (n_z > 0) and below. All equal: the superellipsoid above.
struct SuperExponents {
  double outline = 2, upper = 2, lower = 2;
  bool operator==(const SuperExponents&) const = default;
};
inline constexpr SuperExponents kBoxExponents{1, 1, 1};

/// Support function with three exponents,
///   h(n) = ((|a_x n_x|^q2 + |a_y n_y|^q2)^(q1 / q2) + |a_z n_z|^q1)^(1 / q1),
/// q2 = outline, q1 = upper for n_z > 0, else lower. Continuous at n_z = 0, homogeneous of degree 1, and
/// convex: the body exists. Smoothed as above.
double superellipsoid_support(const Eigen::Vector3d& semi_axes_m, const SuperExponents& q,
                              const Eigen::Vector3d& normal, double smoothing_m = 0);

/// h and its derivatives. For q > 1 or smoothing > 0 they exist everywhere but by `profile` at n_z = 0, where
/// the exponent changes.
struct SupportDerivatives {
  double value = 0;                                       ///< h [m]
  Eigen::Vector3d by_normal = Eigen::Vector3d::Zero();    ///< without smoothing the support point [m]
  Eigen::Vector3d by_log_axes = Eigen::Vector3d::Zero();  ///< d h / d ln a [m]
  double by_outline = 0;                                  ///< d h / d q2 [m]
  double by_profile = 0;                                  ///< d h / d q1 [m]
  bool upper = false;                                     ///< whether q1 is `upper`
};
SupportDerivatives superellipsoid_support_derivatives(const Eigen::Vector3d& semi_axes_m,
                                                      const SuperExponents& q, const Eigen::Vector3d& normal,
                                                      double smoothing_m = 0);

/// The gauge of the body with that support function: below 1 inside, 1 on the surface, above 1 outside; the
/// norms with 1/p + 1/q = 1 for each exponent, the profile's by the sign of z. q > 1.
double superellipsoid_gauge(const Eigen::Vector3d& semi_axes_m, const SuperExponents& q,
                            const Eigen::Vector3d& point);

/// The outward normal of the scaled body on whose surface a point lies: of its gauge's gradient, unit length;
/// zero at the centre.
Eigen::Vector3d superellipsoid_normal(const Eigen::Vector3d& semi_axes_m, const SuperExponents& q,
                                      const Eigen::Vector3d& point);

/// A superellipsoid whose profile runs along any of its axes (0 x, 1 y, 2 z); its outline lies in the two
/// others.
struct Superellipsoid {
  Eigen::Vector3d semi_axes_m;
  SuperExponents exponents{};
  int profile_axis = 2;
  bool operator==(const Superellipsoid&) const = default;
};

inline bool is_box(const Superellipsoid& body) {
  return body.exponents == kBoxExponents;
}
inline bool is_ellipsoid(const Superellipsoid& body) {
  return body.exponents == SuperExponents{};
}

/// Volume in closed form [m^3]: the mean of the volumes that the upper and the lower half would have with
/// their mirror images. Exponents from 1 to 2.
double superellipsoid_volume(const Superellipsoid& body);

/// The point of the body that supports `normal`.
Eigen::Vector3d support_point(const Superellipsoid& body, const Eigen::Vector3d& normal);

/// superellipsoid_gauge() of it.
double gauge(const Superellipsoid& body, const Eigen::Vector3d& point);

/// superellipsoid_normal() of it.
Eigen::Vector3d normal_at(const Superellipsoid& body, const Eigen::Vector3d& point);

}  // namespace uniquadric

#include "core/geometry/superquadric_impl.h"
