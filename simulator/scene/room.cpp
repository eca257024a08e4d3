#include <algorithm>
#include <array>

#include "core/base/random.h"
#include "simulator/scene/mesh_building.h"
#include "simulator/scene/shapes.h"
#include "simulator/scene/solids.h"

namespace uniquadric {
namespace {

struct Surface {
  std::array<Eigen::Vector3d, 4> corners;  ///< in units of half the room, counter-clockwise seen from inside
  TextureStyle style;
  Eigen::Vector3d color, accent;
};

// Six surfaces, six looks: a place recogniser must tell one wall from the next.
const std::array<Surface, 6>& surfaces() {
  using V = Eigen::Vector3d;
  static const std::array<Surface, 6> list = {{
      {{V(-1, -1, -1), V(1, -1, -1), V(1, 1, -1), V(-1, 1, -1)},
       TextureStyle::planks,
       V(.50, .36, .24),
       V(.30, .22, .18)},
      {{V(-1, 1, 1), V(1, 1, 1), V(1, -1, 1), V(-1, -1, 1)},
       TextureStyle::panels,
       V(.70, .70, .68),
       V(.45, .48, .52)},
      {{V(1, 1, -1), V(1, -1, -1), V(1, -1, 1), V(1, 1, 1)},
       TextureStyle::bricks,
       V(.60, .38, .30),
       V(.45, .42, .38)},
      {{V(-1, -1, -1), V(-1, 1, -1), V(-1, 1, 1), V(-1, -1, 1)},
       TextureStyle::strokes,
       V(.45, .55, .62),
       V(.75, .60, .25)},
      {{V(-1, 1, -1), V(1, 1, -1), V(1, 1, 1), V(-1, 1, 1)},
       TextureStyle::panels,
       V(.52, .58, .45),
       V(.65, .45, .35)},
      {{V(1, -1, -1), V(-1, -1, -1), V(-1, -1, 1), V(1, -1, 1)},
       TextureStyle::checks,
       V(.62, .58, .52),
       V(.35, .45, .50)},
  }};
  return list;
}

// Furniture stands with its back to a wall, one piece a slot, so that pieces never overlap.
std::vector<Mesh> furniture_piece(const Eigen::Vector3d& room_m, int index, int count,
                                  const Material& material) {
  RandomStream random(material.seed, "furniture", static_cast<std::uint64_t>(index));
  const int wall = index % 4, slots = (count + 3) / 4, slot = index / 4;
  const bool along_x = wall % 2 == 0;
  const double wall_m = along_x ? room_m.x() : room_m.y(), across_m = along_x ? room_m.y() : room_m.x();
  const double depth = std::min(random.uniform(0.3, 0.55), 0.12 * across_m);
  // The corners, where two walls' pieces could meet, stay free.
  const double slot_m = (wall_m - 2.5 * depth) / slots;
  const double width = std::min(random.uniform(0.5, 1.1), 0.85 * slot_m);
  const double height = std::min(random.uniform(0.5, 1.7), 0.8 * room_m.z());
  const double along = -slot_m * slots / 2 + slot_m * (slot + random.uniform(0.45, 0.55));
  const double away = (wall < 2 ? 1 : -1) * (across_m / 2 - depth / 2 - 0.02);
  const double z = -room_m.z() / 2 + height / 2;
  const Eigen::Vector3d color{random.uniform(.25, .7), random.uniform(.25, .65), random.uniform(.2, .65)};
  Material paint = part_material(material, static_cast<std::uint64_t>(index), color);
  paint.style = static_cast<TextureStyle>(random.below(kTextureStyleNames.size()));
  paint.size_px = std::max(128, material.size_px / 4);
  paint.marks = 12;
  return along_x ? block({along, away, z}, {width, depth, height}, 0, paint)
                 : block({away, along, z}, {depth, width, height}, 0, paint);
}

}  // namespace

std::vector<Mesh> room(const Eigen::Vector3d& size_m, int furniture, const Material& material) {
  std::vector<Mesh> meshes;
  const auto at = [&](const Eigen::Vector3d& corner) -> Eigen::Vector3d {
    return corner.cwiseProduct(size_m) / 2;
  };
  for (const Surface& surface : surfaces()) {
    const auto& c = surface.corners;
    Mesh mesh;
    add_quad(mesh, at(c[0]), at(c[1]), at(c[2]), at(c[3]));
    Material paint = material;
    paint.style = surface.style;
    paint.color = surface.color;
    paint.accent = surface.accent;
    mesh.texture = paint_texture(paint, static_cast<std::uint32_t>(meshes.size()),
                                 (at(c[1]) - at(c[0])).norm(), (at(c[3]) - at(c[0])).norm());
    meshes.push_back(std::move(mesh));
  }
  for (int k = 0; k < furniture; ++k) append(meshes, furniture_piece(size_m, k, furniture, material));
  return meshes;
}

std::vector<Mesh> plane(const Eigen::Vector2d& size_m, const Material& material) {
  const double x = size_m.x() / 2, y = size_m.y() / 2;
  std::vector<Mesh> meshes(1);
  add_quad(meshes[0], {-x, -y, 0}, {x, -y, 0}, {x, y, 0}, {-x, y, 0});
  meshes[0].texture = paint_texture(material, 0, size_m.x(), size_m.y());
  return meshes;
}

}  // namespace uniquadric
