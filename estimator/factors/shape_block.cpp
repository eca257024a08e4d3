#include "estimator/factors/shape_block.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace uniquadric {
namespace {
constexpr double kLargest = 40;  // exp(-40) is lost beside 1
}

AxesBlock axes_block(const Eigen::Vector3d& semi_axes_m) {
  assert(semi_axes_m.minCoeff() > 0);
  return {std::log(semi_axes_m.x()), std::log(semi_axes_m.y()), std::log(semi_axes_m.z())};
}

Eigen::Vector3d axes_from_block(const double* block) {
  return {std::exp(block[0]), std::exp(block[1]), std::exp(block[2])};
}

double exponent_block(double q) {
  assert(q >= 1 && q <= 2);
  return std::clamp(std::log(q - 1) - std::log(2 - q), -kLargest, kLargest);
}

double exponent_from_block(double s) {
  return 1 + 1 / (1 + std::exp(-s));
}

double exponent_slope(double s) {
  const double e = std::exp(-std::abs(s));
  return e / ((1 + e) * (1 + e));
}

SuperExponents exponents_from_block(const double* block, int count) {
  assert(count == 1 || count == 3);
  const double outline = exponent_from_block(block[0]);
  if (count == 1) return {outline, outline, outline};
  return {outline, exponent_from_block(block[1]), exponent_from_block(block[2])};
}

}  // namespace uniquadric
