#include "simulator/map/occupancy_map.h"

#include <fmt/format.h>
#include <octomap/OcTree.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "core/base/error.h"
#include "core/base/files.h"

namespace uniquadric {
namespace {

using Triangle = std::array<Eigen::Vector3d, 3>;
using Cell = Eigen::Matrix<std::int64_t, 3, 1>;

// Whether the projections on an axis of the triangle (relative to the cube's centre) and of the cube are
// apart.
bool is_separated(const Triangle& t, const Eigen::Vector3d& axis, double half_edge) {
  const double a = axis.dot(t[0]), b = axis.dot(t[1]), c = axis.dot(t[2]);
  const double reach = half_edge * axis.cwiseAbs().sum();
  return std::min({a, b, c}) > reach || std::max({a, b, c}) < -reach;
}

// Occupies the cells of edge `size` cells at `corner` that the triangle meets, halving what it meets.
void occupy(octomap::OcTree& tree, const Triangle& triangle, const Cell& corner, std::int64_t size,
            double resolution_m) {
  const double half_edge = 0.5 * static_cast<double>(size) * resolution_m;
  const Eigen::Vector3d center = corner.cast<double>() * resolution_m + Eigen::Vector3d::Constant(half_edge);
  if (!triangle_meets_cube(triangle, center, half_edge)) return;
  if (size == 1) {
    tree.updateNode(octomap::point3d(static_cast<float>(center.x()), static_cast<float>(center.y()),
                                     static_cast<float>(center.z())),
                    true, true);
    return;
  }
  for (int octant = 0; octant < 8; ++octant)
    occupy(tree, triangle, corner + size / 2 * Cell(octant & 1, octant >> 1 & 1, octant >> 2), size / 2,
           resolution_m);
}

void occupy(octomap::OcTree& tree, const Triangle& triangle, double resolution_m) {
  const Eigen::Vector3d low = triangle[0].cwiseMin(triangle[1]).cwiseMin(triangle[2]);
  const Eigen::Vector3d high = triangle[0].cwiseMax(triangle[1]).cwiseMax(triangle[2]);
  const Cell first =
      ((low / resolution_m).array().floor().cast<std::int64_t>() - 1).matrix();  // touching counts
  const std::int64_t extent =
      ((high - low) / resolution_m).array().ceil().cast<std::int64_t>().maxCoeff() + 3;
  std::int64_t size = 1;
  while (size < extent) size *= 2;
  occupy(tree, triangle, first, size, resolution_m);
}

constexpr double kReach_cells = 32'768;  // OctoMap's keys have 16 bits; it drops what lies beyond
constexpr double kMostCells = 3e7;       // ours: about 1 GB and a minute

template <typename Visit>
void for_each_triangle(const std::vector<Body>& world, const Visit& visit) {
  for (const Body& body : world) {
    const Pose world_from_body = body.motion.at(0);
    for (const Mesh& mesh : body.meshes)
      for (const auto& corners : mesh.triangles) {
        Triangle triangle;
        for (int k = 0; k < 3; ++k) triangle[k] = world_from_body * mesh.positions[corners[k]].cast<double>();
        visit(triangle);
      }
  }
}

}  // namespace

bool triangle_meets_cube(const Triangle& triangle, const Eigen::Vector3d& center, double half_edge) {
  const Triangle t = {triangle[0] - center, triangle[1] - center, triangle[2] - center};
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d axis = Eigen::Vector3d::Unit(i);
    if (is_separated(t, axis, half_edge)) return false;
    for (int k = 0; k < 3; ++k)
      if (is_separated(t, axis.cross(t[(k + 1) % 3] - t[k]), half_edge)) return false;
  }
  return !is_separated(t, (t[1] - t[0]).cross(t[2] - t[0]), half_edge);
}

void check_occupancy_map(const std::vector<Body>& world, double resolution_m) {
  double reach_m = 0, area_m2 = 0;
  for_each_triangle(world, [&](const Triangle& t) {
    for (const Eigen::Vector3d& corner : t) reach_m = std::max(reach_m, corner.cwiseAbs().maxCoeff());
    area_m2 += 0.5 * (t[1] - t[0]).cross(t[2] - t[0]).norm();
  });
  const double least_m = std::max(reach_m / (kReach_cells - 2), std::sqrt(area_m2 / kMostCells));
  if (resolution_m < least_m)
    throw InputError(
        fmt::format("map.resolution_m: cells of {} m are too small for a world that reaches {:.3g} m "
                    "and has {:.3g} m^2 of surface; the least is {:.2g} m",
                    resolution_m, reach_m, area_m2, least_m));
}

void write_occupancy_map(const std::filesystem::path& path, const std::vector<Body>& world,
                         double resolution_m) {
  check_occupancy_map(world, resolution_m);
  octomap::OcTree tree(resolution_m);
  for_each_triangle(world, [&](const Triangle& triangle) { occupy(tree, triangle, resolution_m); });
  tree.updateInnerOccupancy();
  tree.toMaxLikelihood();
  tree.prune();
  // OctoMap's own writer of this header also prints to stderr.
  std::ostringstream bytes;
  bytes << "# Octomap OcTree binary file\nid " << tree.getTreeType() << "\nsize " << tree.size() << "\nres "
        << fmt::format("{}", resolution_m) << "\ndata\n";
  tree.writeBinaryData(bytes);
  write_text(path, std::move(bytes).str());
}

}  // namespace uniquadric
