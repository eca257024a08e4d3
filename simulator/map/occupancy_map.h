#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <vector>

#include "simulator/scene/scene.h"

namespace uniquadric {

/// Whether a triangle and an axis-aligned cube share a point (separating axes: Akenine-Moller, "Fast 3D
/// triangle-box overlap testing", 2001). Touching counts.
bool triangle_meets_cube(const std::array<Eigen::Vector3d, 3>& triangle, const Eigen::Vector3d& center,
                         double half_edge);

/// Throws InputError when the world's surfaces reach farther than an octree of 16 levels with cells of this
/// edge, or would occupy tens of millions of cells.
void check_occupancy_map(const std::vector<Body>& world, double resolution_m);

/// The occupancy truth of a scene's static world: an octree in which exactly the cells that a surface of the
/// world meets are occupied; nothing else is known. Checked first. Written as OctoMap's binary tree (.bt).
/// Throws std::runtime_error when the file cannot be written.
void write_occupancy_map(const std::filesystem::path& path, const std::vector<Body>& world,
                         double resolution_m);

}  // namespace uniquadric
