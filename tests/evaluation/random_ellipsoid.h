#pragma once

#include <cmath>

#include "core/base/random.h"
#include "core/geometry/ellipsoid.h"

namespace uniquadric {

inline Eigen::Vector3d random_vector(RandomStream& random, double sigma) {
  const double x = random.normal(), y = random.normal(), z = random.normal();
  return sigma * Eigen::Vector3d(x, y, z);
}

inline Eigen::Quaterniond random_rotation(RandomStream& random) {
  const Eigen::Vector3d v = random_vector(random, 1);
  return Eigen::Quaterniond(random.normal(), v.x(), v.y(), v.z()).normalized();
}

/// Semi-axes about 1 m whose extremes differ by up to `ratio`, centre within a few `spread_m` of the origin.
inline Ellipsoid random_ellipsoid(RandomStream& random, double spread_m, double ratio) {
  Ellipsoid e;
  for (int i = 0; i < 3; ++i) e.semi_axes_m[i] = std::pow(ratio, random.uniform() - 0.5);
  e.world_from_object = {random_rotation(random), random_vector(random, spread_m)};
  return e;
}

}  // namespace uniquadric
