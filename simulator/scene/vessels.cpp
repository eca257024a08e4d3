// Bodies of revolution with a hollow, and what else stands on tables.
#include <cmath>
#include <numbers>
#include <vector>

#include "simulator/scene/mesh_building.h"
#include "simulator/scene/shapes.h"
#include "simulator/scene/solids.h"

namespace uniquadric {
namespace {

constexpr int kAround = 64, kHandle = 24, kHandleAround = 12;
constexpr double kTurn = 2 * std::numbers::pi;

// (radius, height) from the axis below, outside up, over the rim and inside down to the axis.
using Profile = std::vector<Eigen::Vector2d>;

Mesh revolved(const Profile& profile, const Material& material) {
  Mesh mesh;
  const int rows = static_cast<int>(profile.size()) - 1;
  add_grid(mesh, rows, kAround, [&](int i, int j) {
    const double angle = kTurn * (j % kAround) / kAround;
    const Eigen::Vector2d& p = profile[static_cast<std::size_t>(i)];
    return Vertex{{p.x() * std::cos(angle), p.x() * std::sin(angle), p.y()},
                  Eigen::Vector3d::UnitZ(),
                  {static_cast<double>(j) / kAround, 1 - static_cast<double>(i) / rows}};
  });
  smooth_normals(mesh);
  mesh.texture = paint_texture(material, 0, std::numbers::pi, 1);
  return mesh;
}

// Half a ring in the plane y = 0 whose ends meet the wall at x = `wall`.
Mesh handle(double wall, double half_height, double reach, double thickness, const Material& material) {
  Mesh mesh;
  add_grid(mesh, kHandleAround, kHandle, [&](int i, int j) {
    const double along = std::numbers::pi * (static_cast<double>(j) / kHandle - 0.5);
    const double around = kTurn * (i % kHandleAround) / kHandleAround;
    const Eigen::Vector3d out(std::cos(along), 0, std::sin(along));
    const Eigen::Vector3d middle(wall + reach * std::cos(along), 0, half_height * std::sin(along));
    const Eigen::Vector3d at =
        middle + thickness * (std::cos(around) * out + std::sin(around) * Eigen::Vector3d::UnitY());
    return Vertex{at, out, {static_cast<double>(j) / kHandle, static_cast<double>(i) / kHandleAround}};
  });
  smooth_normals(mesh);
  mesh.texture = paint_texture(material, 1, 2, 1);
  return mesh;
}

Profile wall_profile(double foot, double rim, double wall, int steps, double bend) {
  Profile profile{{0, -1}};
  const auto radius = [&](double share) { return foot + (rim - foot) * std::pow(share, bend); };
  for (int k = 0; k <= steps; ++k)
    profile.emplace_back(radius(static_cast<double>(k) / steps), 2.0 * k / steps - 1);
  for (int k = steps; k >= 0; --k) {
    const double share = static_cast<double>(k) / steps;
    profile.emplace_back(radius(share) - wall, std::max(2 * share - 1, -1 + 2 * wall));
  }
  profile.emplace_back(0, -1 + 2 * wall);
  return profile;
}

}  // namespace

std::vector<Mesh> mug(const Eigen::Vector3d& size_m, const Material& material) {
  std::vector<Mesh> meshes{revolved(wall_profile(1, 1, 0.08, 2, 1), material),
                           handle(0.97, 0.6, 0.5, 0.12, material)};
  fit_to_box(meshes, size_m);
  return meshes;
}

std::vector<Mesh> bowl(const Eigen::Vector3d& size_m, const Material& material) {
  std::vector<Mesh> meshes{revolved(wall_profile(0.4, 1, 0.06, 12, 0.5), material)};
  fit_to_box(meshes, size_m);
  return meshes;
}

std::vector<Mesh> angle(const Eigen::Vector3d& size_m, double thickness, const Material& material) {
  const double t = thickness * size_m.x(), u = thickness * size_m.z();
  // the outline in x, z, counter-clockwise seen from -y
  const std::vector<Eigen::Vector2d> outline = {{0, 0}, {size_m.x(), 0}, {size_m.x(), u},
                                                {t, u}, {t, size_m.z()}, {0, size_m.z()}};
  const auto at = [&](std::size_t k, double y) {
    return Eigen::Vector3d(outline[k % 6].x(), y * size_m.y(), outline[k % 6].y());
  };
  std::vector<Mesh> meshes;
  const auto add_face = [&](const auto& a, const auto& b, const auto& c, const auto& d) {
    Mesh mesh;
    add_quad(mesh, a, b, c, d);
    mesh.texture =
        paint_texture(material, static_cast<std::uint32_t>(meshes.size()), (b - a).norm(), (d - a).norm());
    meshes.push_back(std::move(mesh));
  };
  for (std::size_t k = 0; k < 6; ++k) add_face(at(k + 1, 0), at(k, 0), at(k, 1), at(k + 1, 1));
  const auto foot = [&](double y) { return Eigen::Vector3d(0, y * size_m.y(), u); };
  add_face(at(0, 0), at(1, 0), at(2, 0), foot(0));
  add_face(foot(0), at(3, 0), at(4, 0), at(5, 0));
  add_face(at(1, 1), at(0, 1), foot(1), at(2, 1));
  add_face(at(3, 1), foot(1), at(5, 1), at(4, 1));
  fit_to_box(meshes, size_m);
  return meshes;
}

std::vector<Mesh> pedestrian(const Eigen::Vector3d& size_m, const Material& material) {
  const double L = size_m.x(), W = size_m.y(), H = size_m.z();
  const auto part = [&](const Eigen::Vector3d& at, const Eigen::Vector3d& extents, int n,
                        const Eigen::Vector3d& color) {
    auto meshes = ellipsoid(extents, 8, part_material(material, static_cast<std::uint64_t>(n), color));
    transform(meshes, {Eigen::Quaterniond::Identity(), at});
    return meshes;
  };
  const Eigen::Vector3d skin(0.75, 0.6, 0.5);
  auto meshes = part({0, 0, 0.64 * H}, {0.6 * L, 0.75 * W, 0.44 * H}, 0, material.color);
  append(meshes, part({0, 0, 0.93 * H}, {0.4 * L, 0.35 * W, 0.14 * H}, 1, skin));
  append(meshes, part({0.18 * L, 0.16 * W, 0.25 * H}, {0.55 * L, 0.3 * W, 0.5 * H}, 2, material.accent));
  append(meshes, part({-0.18 * L, -0.16 * W, 0.25 * H}, {0.55 * L, 0.3 * W, 0.5 * H}, 3, material.accent));
  for (const double side : {-1.0, 1.0})
    append(meshes, part({side * 0.2 * L, side * 0.42 * W, 0.62 * H}, {0.35 * L, 0.16 * W, 0.36 * H}, 4,
                        material.color));
  fit_to_box(meshes, size_m);
  return meshes;
}

std::vector<Mesh> cyclist(const Eigen::Vector3d& size_m, const Material& material) {
  const double L = size_m.x(), W = size_m.y(), H = size_m.z(), radius_m = 0.19 * L;
  const Material metal = part_material(material, 1, {0.3, 0.3, 0.33});
  auto meshes = pedestrian({0.35 * L, W, 0.72 * H}, material);
  transform(meshes, {Eigen::Quaterniond::Identity(), {-0.05 * L, 0, 0.64 * H}});
  for (const double end : {-1.0, 1.0})
    append(meshes, wheel({end * (0.5 * L - radius_m), 0, radius_m}, radius_m, 0.08 * W, metal));
  append(meshes, block({0, 0, 0.3 * H}, {0.5 * L, 0.06 * W, 0.05 * H}, 0, metal));
  append(meshes, block({0.28 * L, 0, 0.5 * H}, {0.03 * L, 0.8 * W, 0.04 * H}, 0, metal));
  fit_to_box(meshes, size_m);
  return meshes;
}

}  // namespace uniquadric
