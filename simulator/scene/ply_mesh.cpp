#include "simulator/scene/ply_mesh.h"

#include <algorithm>
#include <tuple>

#include "simulator/scene/mesh_building.h"

namespace uniquadric {
namespace {

// A point of a surface has a vertex for each of its texture coordinates.
using Corner = std::tuple<std::uint32_t, float, float>;

std::vector<std::array<Corner, 3>> corners_of(const SurfaceFile& surface) {
  std::vector<std::array<Corner, 3>> corners(surface.triangles.size());
  for (std::size_t i = 0; i < corners.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const Eigen::Vector2f uv = surface.uvs.empty() ? Eigen::Vector2f::Zero() : surface.uvs[i][k];
      corners[i][k] = {surface.triangles[i][k], uv.x(), uv.y()};
    }
  return corners;
}

}  // namespace

Mesh mesh_of(const SurfaceFile& surface) {
  const auto corners = corners_of(surface);
  std::vector<Corner> vertices;
  for (const auto& triangle : corners) vertices.insert(vertices.end(), triangle.begin(), triangle.end());
  std::ranges::sort(vertices);
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  Mesh mesh;
  for (const auto& [point, u, v] : vertices) {
    mesh.positions.push_back(surface.points[point]);
    mesh.normals.push_back(surface.normals.empty() ? Eigen::Vector3f::Zero() : surface.normals[point]);
    mesh.uvs.emplace_back(u, 1 - v);  // files count it upwards
  }
  for (const auto& triangle : corners) {
    auto& added = mesh.triangles.emplace_back();
    for (std::size_t k = 0; k < 3; ++k)
      added[k] =
          static_cast<std::uint32_t>(std::ranges::lower_bound(vertices, triangle[k]) - vertices.begin());
  }
  if (surface.normals.empty()) smooth_normals(mesh);
  for (Eigen::Vector3f& normal : mesh.normals) normal = unit_normal(normal);
  return mesh;
}

}  // namespace uniquadric
