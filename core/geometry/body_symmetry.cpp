#include "core/geometry/body_symmetry.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace uniquadric {
namespace {

constexpr std::pair<BodySymmetry, const char*> kNames[] = {{BodySymmetry::box, "box"},
                                                           {BodySymmetry::revolution, "revolution"},
                                                           {BodySymmetry::sphere, "sphere"},
                                                           {BodySymmetry::none, "none"}};

}  // namespace

bool equal_axes(double a, double b) {
  return std::abs(a - b) <= kEqualAxes * std::max(a, b);
}

const char* to_string(BodySymmetry symmetry) {
  for (const auto& [known, name] : kNames)
    if (known == symmetry) return name;
  return "";
}

std::optional<BodySymmetry> parse_body_symmetry(std::string_view text) {
  for (const auto& [symmetry, name] : kNames)
    if (text == name) return symmetry;
  return std::nullopt;
}

std::optional<int> revolution_axis(const Eigen::Vector3d& semi_axes_m) {
  std::optional<int> found;
  double least = 0;
  int equal_pairs = 0;
  for (const int axis : {2, 0, 1}) {
    const double a = semi_axes_m[(axis + 1) % 3], b = semi_axes_m[(axis + 2) % 3];
    if (!equal_axes(a, b)) continue;
    ++equal_pairs;
    if (found && !(std::abs(a - b) < least)) continue;
    found = axis;
    least = std::abs(a - b);
  }
  return equal_pairs == 3 ? std::optional(2) : found;
}

bool allows(const Eigen::Vector3d& semi_axes_m, BodySymmetry symmetry) {
  if (symmetry == BodySymmetry::revolution) return revolution_axis(semi_axes_m).has_value();
  if (symmetry == BodySymmetry::sphere)
    return equal_axes(semi_axes_m.x(), semi_axes_m.y()) && equal_axes(semi_axes_m.y(), semi_axes_m.z()) &&
           equal_axes(semi_axes_m.z(), semi_axes_m.x());
  return true;
}

}  // namespace uniquadric
