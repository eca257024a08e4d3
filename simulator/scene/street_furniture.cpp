#include "simulator/scene/mesh_building.h"
#include "simulator/scene/shapes.h"
#include "simulator/scene/solids.h"
#include "simulator/scene/street_parts.h"

namespace uniquadric {
namespace {

Pose up(double z_m) {
  return {Eigen::Quaterniond::Identity(), {0, 0, z_m}};
}

std::vector<Mesh> post(double radius_m, double height_m, const Material& material) {
  auto meshes = cylinder({2 * radius_m, 2 * radius_m, height_m}, 16, material);
  transform(meshes, up(height_m / 2));
  return meshes;
}

}  // namespace

std::vector<Mesh> street_lamp(double height_m, const Material& metal) {
  auto meshes = post(0.09, height_m, metal);
  Mesh head;
  add_box(head, {0, 0, 0.2}, {0.36, 0.36, 0.4});                // foot
  add_box(head, {0.5, 0, height_m}, {1.2, 0.1, 0.1});           // arm
  add_box(head, {1.1, 0, height_m - 0.02}, {0.6, 0.28, 0.14});  // light
  add_box(head, {0, 0, 0.42 * height_m}, {0.6, 0.06, 0.75});    // sign
  head.texture = paint_texture(metal, 3, 1, 1);
  meshes.push_back(std::move(head));
  return meshes;
}

std::vector<Mesh> tree(double height_m, const Material& bark, const Material& leaves) {
  auto meshes = post(0.16, 0.5 * height_m, bark);
  constexpr int kSegments = 4;
  const Eigen::Vector3d crowns[] = {{0, 0, 0.7}, {0.35, 0.2, 0.55}, {-0.3, -0.25, 0.6}};
  const double widths[] = {0.5, 0.34, 0.38};
  for (int k = 0; k < 3; ++k) {
    const double width_m = widths[k] * height_m;
    auto crown = ellipsoid({width_m, width_m, (k == 0 ? 0.6 : 0.4) * height_m}, kSegments, leaves);
    transform(crown, {Eigen::Quaterniond::Identity(),
                      0.5 * widths[0] * height_m * crowns[k].cwiseProduct(Eigen::Vector3d(1, 1, 0)) +
                          Eigen::Vector3d(0, 0, crowns[k].z() * height_m)});
    append(meshes, std::move(crown));
  }
  return meshes;
}

std::vector<Mesh> kiosk(const Eigen::Vector3d& size_m, const Material& walls, const Material& roof) {
  const double roof_m = 0.15 * size_m.z(), wall_m = size_m.z() - roof_m;
  auto meshes = block({0, 0, wall_m / 2}, {0.9 * size_m.x(), 0.9 * size_m.y(), wall_m}, 0, walls);
  append(meshes,
         frustum({0, 0, wall_m + roof_m / 2}, size_m.head<2>(), 0.6 * size_m.head<2>(), roof_m, roof));
  return meshes;
}

}  // namespace uniquadric
