#include "evaluation/iou/solid.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace uniquadric {
namespace {

// The power p with 1/p + 1/q = 1.
double power_of(double q) {
  return q > 1 ? q / (q - 1) : std::numeric_limits<double>::infinity();
}

// The p-norm of two numbers in [0, 1]; powers of large numbers alone, none of which vanishes.
double norm_of(double u, double v, double p) {
  if (p == 2) return std::sqrt(u * u + v * v);
  const double large = std::max(u, v), small = std::min(u, v);
  if (!(small > 0) || std::isinf(p)) return large;
  return large * std::pow(1 + std::pow(small / large, p), 1 / p);
}

constexpr int kMostSquarings = 6;  // ours: a power of 64 leaves 0.1 % of the box

}  // namespace

Eigen::AlignedBox3d bounding_box(const Solid& solid) {
  if (solid.mesh) return solid.mesh->box();
  return {-solid.body.semi_axes_m, solid.body.semi_axes_m};
}

std::optional<double> known_volume(const Solid& solid) {
  return solid.mesh ? solid.mesh->known_volume() : std::optional(superellipsoid_volume(solid.body));
}

InsideTest::InsideTest(const Superellipsoid& body, const Pose& points_from_body)
    : middle_(points_from_body.translation),
      outline_(power_of(body.exponents.outline)),
      upper_(power_of(body.exponents.upper)),
      lower_(power_of(body.exponents.lower)) {
  const Eigen::Matrix3d body_from_points = points_from_body.rotation.conjugate().toRotationMatrix();
  for (int i = 0; i < 3; ++i) {  // the profile's axis last
    const int axis = (body.profile_axis + 1 + i) % 3;
    unit_from_points_.row(i) = body_from_points.row(axis) / body.semi_axes_m[axis];
  }
  const auto [least, most] = std::minmax({outline_, upper_, lower_});
  inner_ = least >= 1 << kMostSquarings ? kMostSquarings : std::ilogb(least);
  if (most <= 1 << kMostSquarings) outer_ = static_cast<int>(std::ceil(std::log2(most)));
}

// The greater a norm's power, the larger the body.
bool InsideTest::contains(const Eigen::Vector3d& point) const {
  const Eigen::Array3d unit = unit_from_points_ * (point - middle_);
  Eigen::Array3d power = unit.square();
  if ((power > 1).any()) return false;
  int squarings = 1;
  for (; squarings < inner_; ++squarings) power *= power;
  if (power.sum() <= 1) return true;
  for (; outer_ && squarings < *outer_; ++squarings) power *= power;
  if (outer_ && power.sum() > 1) return false;
  const Eigen::Array3d u = unit.abs();
  return norm_of(norm_of(u.x(), u.y(), outline_), u.z(), unit.z() > 0 ? upper_ : lower_) <= 1;
}

std::vector<char> contains(const Solid& solid, std::span<const Eigen::Vector3d> points) {
  if (solid.mesh) return solid.mesh->contains(points);
  const InsideTest test(solid.body);
  std::vector<char> inside;
  for (const Eigen::Vector3d& point : points) inside.push_back(test.contains(point));
  return inside;
}

}  // namespace uniquadric
