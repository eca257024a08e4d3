#pragma once

#include <Eigen/Core>
#include <optional>
#include <string_view>

namespace uniquadric {

/// Semi-axes that differ by no more than this share of the larger count as equal (SPEC: 5 %).
inline constexpr double kEqualAxes = 0.05;
bool equal_axes(double a, double b);

/// What a body's own shape leaves open about its orientation.
enum class BodySymmetry {
  box,         ///< the box rotations that keep the true semi-axes, equal ones within 5 %
  revolution,  ///< any turn about one axis, and its flip
  sphere,      ///< any rotation
  none,        ///< nothing
};
const char* to_string(BodySymmetry symmetry);
std::optional<BodySymmetry> parse_body_symmetry(std::string_view text);

/// The axis of revolution that semi-axes allow, 0 to 2: the one whose two others are equal, of two such the
/// one whose others are closer, of three z (cylinders stand along z). Nothing where no two are equal.
std::optional<int> revolution_axis(const Eigen::Vector3d& semi_axes_m);

/// Whether a body with these semi-axes can have that symmetry.
bool allows(const Eigen::Vector3d& semi_axes_m, BodySymmetry symmetry);

}  // namespace uniquadric
