#include "core/geometry/sphere_direction.h"

#include <cmath>
#include <numbers>

namespace uniquadric {

Eigen::Vector3d sphere_direction(int index, int count) {
  const double z = 1 - (2 * index + 1.0) / count, angle = index * std::numbers::pi * (3 - std::sqrt(5.0));
  const double radius = std::sqrt(1 - z * z);
  return {radius * std::cos(angle), radius * std::sin(angle), z};
}

}  // namespace uniquadric
