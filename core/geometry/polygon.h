#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace uniquadric {

/// A polygon's triangles, of indices into its corners, wound as it is: ears cut off in turn (Meisters, 1975),
/// of a convex one the fan of the first corner. Corners that lie in no plane are taken as their vector area
/// sees them. Two triangles fewer than corners, also where the polygon cuts itself or has no area; none of
/// fewer than three. Takes time of the corners' number squared at least.
std::vector<std::array<std::uint32_t, 3>> triangulate(const std::vector<Eigen::Vector3f>& corners);

}  // namespace uniquadric
