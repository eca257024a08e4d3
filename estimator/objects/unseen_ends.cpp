#include "estimator/objects/unseen_ends.h"

#include <cmath>
#include <numbers>
#include <vector>

#include "core/geometry/superquadric.h"
#include "estimator/shape/to_matrix.h"

namespace uniquadric {
namespace {

constexpr int kDirections = 100;
constexpr double kGoldenAngle = 2 * std::numbers::pi / (1 + std::numbers::phi);  // [rad]: spreads directions
constexpr double kSmoothing_m = 1e-4;
constexpr double kNear = 0.25;  // radii

}  // namespace

Eigen::Matrix3Xd unseen_ends(const Shape& shape, const Eigen::Matrix3Xd& seen, double radius_m) {
  std::vector<Eigen::Vector3d> ends;
  for (int i = 0; i < kDirections; ++i) {
    const double z = 1 - (2.0 * i + 1) / kDirections, angle = kGoldenAngle * (i + 0.5);
    const double around = std::sqrt(1 - z * z);
    const Eigen::Vector3d direction(around * std::cos(angle), around * std::sin(angle), z);
    const Eigen::Vector3d end =
        shape.body_from_object *
        superellipsoid_support_derivatives(shape.semi_axes_m, shape.exponents, direction, kSmoothing_m)
            .by_normal;
    if (seen.cols() == 0 || (seen.colwise() - end).colwise().norm().minCoeff() > kNear * radius_m)
      ends.push_back(end);
  }
  return to_matrix(ends);
}

}  // namespace uniquadric
