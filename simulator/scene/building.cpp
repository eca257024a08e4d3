#include <algorithm>
#include <cmath>
#include <vector>

#include "simulator/scene/mesh_building.h"
#include "simulator/scene/street_parts.h"

namespace uniquadric {
namespace {

constexpr double kStorey_m = 3.2, kWindow_m = 1.3, kBay_m = 2.6, kRecess_m = 0.22;

// Lines that cut one side of a facade: wall, window, wall, window, ..., wall.
std::vector<double> cuts(double length_m, double bay_m, double window_m) {
  const int windows = std::max(1, static_cast<int>(length_m / bay_m));
  std::vector<double> lines{0};
  for (int k = 0; k < windows; ++k) {
    const double middle = length_m * (k + 0.5) / windows;
    lines.push_back(middle - window_m / 2);
    lines.push_back(middle + window_m / 2);
  }
  lines.push_back(length_m);
  return lines;
}

bool is_window(int row, int column) {
  return row % 2 == 1 && column % 2 == 1;
}

Mesh wall_with_openings(const std::vector<double>& x, const std::vector<double>& z) {
  Mesh wall;
  add_grid(
      wall, static_cast<int>(z.size()) - 1, static_cast<int>(x.size()) - 1,
      [&](int i, int j) {
        return Vertex{{x[j] - x.back() / 2, 0, z[i]},
                      -Eigen::Vector3d::UnitY(),
                      {x[j] / x.back(), 1 - z[i] / z.back()}};
      },
      is_window);
  return wall;
}

// A pane set back from the wall, and the four sides of the opening around it.
void add_window(Mesh& panes, Mesh& wall, double x0, double x1, double z0, double z1) {
  const Eigen::Vector3d back(0, kRecess_m, 0);
  const Eigen::Vector3d rim[4] = {{x0, 0, z0}, {x1, 0, z0}, {x1, 0, z1}, {x0, 0, z1}};
  add_quad(panes, rim[0] + back, rim[1] + back, rim[2] + back, rim[3] + back);
  for (int k = 0; k < 4; ++k)
    add_quad(wall, rim[k], rim[(k + 1) % 4], rim[(k + 1) % 4] + back, rim[k] + back);
}

// Ledges above each storey, a cornice, an awning over the shop.
Mesh trim(const Eigen::Vector3d& size_m, int storeys) {
  const double w = size_m.x(), h = size_m.z();
  Mesh mesh;
  for (int k = 1; k < storeys; ++k) add_box(mesh, {0, -0.07, h * k / storeys}, {w, 0.14, 0.16});
  add_box(mesh, {0, -0.12, h - 0.2}, {w, 0.24, 0.4});
  add_box(mesh, {0, -0.5, 0.86 * h / storeys}, {0.7 * w, 1.0, 0.12});
  return mesh;
}

Mesh other_faces(const Eigen::Vector3d& size_m) {
  const double x = size_m.x() / 2, y = size_m.y(), z = size_m.z();
  Mesh mesh;
  add_quad(mesh, {x, 0, 0}, {x, y, 0}, {x, y, z}, {x, 0, z});
  add_quad(mesh, {x, y, 0}, {-x, y, 0}, {-x, y, z}, {x, y, z});
  add_quad(mesh, {-x, y, 0}, {-x, 0, 0}, {-x, 0, z}, {-x, y, z});
  add_quad(mesh, {-x, 0, z}, {x, 0, z}, {x, y, z}, {-x, y, z});
  return mesh;
}

}  // namespace

void add_box(Mesh& mesh, const Eigen::Vector3d& centre, const Eigen::Vector3d& size_m) {
  const auto corner = [&](double x, double y, double z) -> Eigen::Vector3d {
    return centre + Eigen::Vector3d(x, y, z).cwiseProduct(size_m) / 2;
  };
  for (const double s : {-1.0, 1.0}) {  // the second of each pair of faces is wound the other way
    add_quad(mesh, corner(s, -s, -1), corner(s, s, -1), corner(s, s, 1), corner(s, -s, 1));
    add_quad(mesh, corner(s, s, -1), corner(-s, s, -1), corner(-s, s, 1), corner(s, s, 1));
    add_quad(mesh, corner(-1, -s, s), corner(1, -s, s), corner(1, s, s), corner(-1, s, s));
  }
}

std::vector<Mesh> building(const Eigen::Vector3d& size_m, const Material& wall_paint,
                           const Material& trim_paint, const Material& glass) {
  const int storeys = std::max(1, static_cast<int>(size_m.z() / kStorey_m));
  const auto x = cuts(size_m.x(), kBay_m, kWindow_m), z = cuts(size_m.z(), size_m.z() / storeys, 1.6);
  std::vector<Mesh> meshes{wall_with_openings(x, z), {}, trim(size_m, storeys), other_faces(size_m)};
  for (std::size_t i = 1; i + 1 < z.size(); i += 2)
    for (std::size_t j = 1; j + 1 < x.size(); j += 2)
      add_window(meshes[1], meshes[0], x[j] - size_m.x() / 2, x[j + 1] - size_m.x() / 2, z[i], z[i + 1]);
  meshes[0].texture = paint_texture(wall_paint, 0, size_m.x(), size_m.z());
  meshes[1].texture = paint_texture(glass, 1, kWindow_m, 1.6);
  meshes[2].texture = paint_texture(trim_paint, 2, 4, 1);
  Material coarse = wall_paint;  // seen at a glancing angle or not at all
  coarse.size_px = std::max(16, coarse.size_px / 4);
  meshes[3].texture = paint_texture(coarse, 3, size_m.x(), size_m.z());
  return meshes;
}

}  // namespace uniquadric
