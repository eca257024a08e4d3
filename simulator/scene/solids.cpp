#include "simulator/scene/solids.h"

#include <array>
#include <cassert>
#include <cmath>
#include <numbers>

#include "simulator/scene/mesh_building.h"

namespace uniquadric {
namespace {

constexpr int kWheelSegments = 32;

Pose shift(const Eigen::Vector3d& by) {
  return {Eigen::Quaterniond::Identity(), by};
}

Mesh cylinder_side(int segments, const Material& material) {
  Mesh mesh;
  add_grid(mesh, 1, segments, [&](int i, int j) {
    const double angle = 2 * std::numbers::pi * (j % segments) / segments;  // the seam repeats exactly
    const Eigen::Vector3d out(std::cos(angle), std::sin(angle), 0);
    return Vertex{{out.x(), out.y(), i == 0 ? -1.0 : 1.0}, out, {static_cast<double>(j) / segments, 1.0 - i}};
  });
  mesh.texture = paint_texture(material, 0, std::numbers::pi, 1);
  return mesh;
}

Mesh cylinder_cap(int segments, double z, const Material& material) {
  Mesh mesh;
  const Eigen::Vector3d normal(0, 0, z);
  const auto add = [&](double x, double y) {
    mesh.positions.push_back(Eigen::Vector3d(x, y, z).cast<float>());
    mesh.normals.push_back(normal.cast<float>());
    mesh.uvs.push_back(Eigen::Vector2d(0.5 + 0.5 * z * x, 0.5 - 0.5 * y).cast<float>());
  };
  add(0, 0);
  for (int j = 0; j < segments; ++j) {
    const double angle = 2 * std::numbers::pi * j / segments;
    add(std::cos(angle), std::sin(angle));
    const auto a = static_cast<std::uint32_t>(1 + j), b = static_cast<std::uint32_t>(1 + (j + 1) % segments);
    if (z > 0)
      mesh.triangles.push_back({0, a, b});
    else
      mesh.triangles.push_back({0, b, a});
  }
  mesh.texture = paint_texture(material, z > 0 ? 1 : 2, 1, 1);
  return mesh;
}

}  // namespace

std::vector<Mesh> cylinder(const Eigen::Vector3d& size_m, int segments, const Material& material) {
  assert(segments % 4 == 0 && segments > 0);
  std::vector<Mesh> meshes{cylinder_side(segments, material), cylinder_cap(segments, 1, material),
                           cylinder_cap(segments, -1, material)};
  fit_to_box(meshes, size_m);
  return meshes;
}

std::vector<Mesh> wheel(const Eigen::Vector3d& centre, double radius_m, double width_m,
                        const Material& material) {
  auto meshes = cylinder({2 * radius_m, 2 * radius_m, width_m}, kWheelSegments, material);
  const Eigen::Quaterniond upright(Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitX()));
  transform(meshes, {upright, centre});
  return meshes;
}

std::vector<Mesh> block(const Eigen::Vector3d& centre, const Eigen::Vector3d& size_m, double radius_m,
                        const Material& material) {
  auto meshes = rounded_box(size_m, {.radius_m = radius_m}, material);
  transform(meshes, shift(centre));
  return meshes;
}

std::vector<Mesh> frustum(const Eigen::Vector3d& centre, const Eigen::Vector2d& base_m,
                          const Eigen::Vector2d& top_m, double height_m, const Material& material) {
  const auto corner = [&](int k, bool top) -> Eigen::Vector3d {
    const Eigen::Vector2d half = (top ? top_m : base_m) / 2;
    const double x = k == 1 || k == 2 ? half.x() : -half.x(), y = k >= 2 ? half.y() : -half.y();
    return centre + Eigen::Vector3d(x, y, top ? height_m / 2 : -height_m / 2);
  };
  std::vector<Mesh> meshes(6);
  for (int k = 0; k < 4; ++k) {
    const int next = (k + 1) % 4;
    add_quad(meshes[k], corner(k, false), corner(next, false), corner(next, true), corner(k, true));
    meshes[k].texture = paint_texture(material, k, (corner(next, false) - corner(k, false)).norm(), height_m);
  }
  add_quad(meshes[4], corner(0, true), corner(1, true), corner(2, true), corner(3, true));
  add_quad(meshes[5], corner(1, false), corner(0, false), corner(3, false), corner(2, false));
  meshes[4].texture = paint_texture(material, 4, top_m.x(), top_m.y());
  meshes[5].texture = paint_texture(material, 5, base_m.x(), base_m.y());
  return meshes;
}

Material part_material(const Material& body, std::uint64_t part, const Eigen::Vector3d& color) {
  Material material = body;
  material.color = color;
  material.seed = body.seed * 64 + part + 1;  // fewer than 64 parts a body
  material.size_px = body.size_px / 2;
  return material;
}

}  // namespace uniquadric
