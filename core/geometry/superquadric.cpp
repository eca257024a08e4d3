#include "core/geometry/superquadric.h"

#include <cmath>

namespace uniquadric {

Eigen::Vector3d superellipsoid_support_point(const Eigen::Vector3d& semi_axes_m, double q,
                                             const Eigen::Vector3d& normal) {
  const double h = superellipsoid_support<double>(semi_axes_m, q, normal);
  Eigen::Vector3d point;
  for (int i = 0; i < 3; ++i) {
    const double v = semi_axes_m[i] * normal[i];
    point[i] = h > 0 ? semi_axes_m[i] * std::copysign(std::pow(std::abs(v) / h, q - 1), v) : 0.0;
  }
  return point;
}

// Dirichlet's integral: V = 8 a b c Gamma(1 + 1/p)^3 / Gamma(1 + 3/p), with 1/p = 1 - 1/q.
double superellipsoid_volume(const Eigen::Vector3d& semi_axes_m, double q) {
  const double inverse_p = 1 - 1 / q;
  return 8 * semi_axes_m.prod() * std::pow(std::tgamma(1 + inverse_p), 3) / std::tgamma(1 + 3 * inverse_p);
}

}  // namespace uniquadric
