#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <utility>

#include "simulator/scene/mesh_building.h"
#include "simulator/scene/shapes.h"
#include "simulator/scene/solids.h"

namespace uniquadric {
namespace {

const Eigen::Vector3d kRubber(0.22, 0.22, 0.24), kMetal(0.55, 0.56, 0.6), kGlass(0.3, 0.38, 0.45);

/// The board in shares of its length L, width W and height H; z from the wheels' contact.
struct Deck {
  Eigen::Vector3d size_m;
  static constexpr double kThickness = 0.08;  // of H
  static constexpr double kUnderside = 0.52;  // of H, between the trucks
  static constexpr double kFlat = 0.6;        // of L, level
  static constexpr double kTip = 0.45;        // of W, at nose and tail

  double rise(double x) const {  // smooth, level in the middle
    const double beyond = std::max(0.0, std::abs(x) - kFlat / 2) / (0.5 - kFlat / 2);
    return (1 - kThickness - kUnderside) * beyond * beyond * (3 - beyond) / 2;
  }
  double width(double x) const {
    const double beyond = std::max(0.0, std::abs(x) - kFlat / 2) / (0.5 - kFlat / 2);
    return kTip + (1 - kTip) * std::sqrt(std::max(0.0, 1 - beyond * beyond));
  }
  /// x in [-1/2, 1/2], y in [-1, 1] across.
  Eigen::Vector3d at(double x, double y, bool top) const {
    const double z = kUnderside + rise(x) + (top ? kThickness : 0);
    return Eigen::Vector3d(x, y * width(x) / 2, z).cwiseProduct(size_m);
  }
};

constexpr int kLong = 64, kAcross = 8;  // cells of the deck

double deck_x(int j) {
  return -0.5 * std::cos(std::numbers::pi * j / kLong);  // dense at the round ends
}
double deck_y(int i) {
  return 2.0 * i / kAcross - 1;
}

Mesh deck_face(const Deck& deck, const Material& material, bool top) {
  Mesh mesh;
  const int side = top ? 1 : -1;
  add_grid(mesh, kAcross, kLong, [&](int i, int j) {
    const double x = deck_x(j), y = side * deck_y(i);
    return Vertex{deck.at(x, y, top), Eigen::Vector3d::UnitZ() * side, {x + 0.5, 0.5 - 0.5 * y}};
  });
  smooth_normals(mesh);
  mesh.texture = paint_texture(material, top ? 0 : 1, deck.size_m.x(), deck.size_m.y());
  return mesh;
}

// The wall between the deck's two faces, one strip a side; it repeats the faces' own rim vertices.
Mesh deck_rim(const Deck& deck, const Material& material) {
  Mesh mesh;
  const auto strip = [&](int cells, const std::function<Eigen::Vector2d(int)>& rim) {
    add_grid(mesh, 1, cells, [&](int i, int j) {
      const Eigen::Vector2d at = rim(j);
      return Vertex{deck.at(at.x(), at.y(), i == 1),
                    Eigen::Vector3d::UnitX(),
                    {static_cast<double>(j) / cells, 1.0 - i}};
    });
  };
  strip(kLong, [](int j) { return Eigen::Vector2d(deck_x(j), -1); });
  strip(kLong, [](int j) { return Eigen::Vector2d(deck_x(kLong - j), 1); });
  strip(kAcross, [](int j) { return Eigen::Vector2d(0.5, deck_y(j)); });
  strip(kAcross, [](int j) { return Eigen::Vector2d(-0.5, deck_y(kAcross - j)); });
  smooth_normals(mesh);
  mesh.texture = paint_texture(material, 2, deck.size_m.x(), deck.size_m.z());
  return mesh;
}

std::vector<Mesh> truck(const Eigen::Vector3d& size_m, double x, const Material& metal,
                        const Material& rubber) {
  const double W = size_m.y(), H = size_m.z();
  const double wheel_radius = std::min(0.19 * H, 0.06 * size_m.x());
  auto meshes = block({x, 0, 0.36 * H}, {0.07 * size_m.x(), 0.25 * W, 0.36 * H}, 0, metal);
  append(meshes, block({x, 0, wheel_radius}, {0.03 * size_m.x(), 0.75 * W, 0.1 * H}, 0, metal));
  for (const double side : {-1.0, 1.0})
    append(meshes, wheel({x, side * 0.4 * W, wheel_radius}, wheel_radius, 0.16 * W, rubber));
  return meshes;
}

void add_wheels(std::vector<Mesh>& meshes, double x, double y, double radius_m, double width_m,
                const Material& rubber) {
  for (const double end : {-x, x})
    for (const double side : {-y, y}) append(meshes, wheel({end, side, radius_m}, radius_m, width_m, rubber));
}

Material rubber_of(const Material& material) {
  Material rubber = part_material(material, 2, kRubber);
  rubber.accent = 1.6 * kRubber;
  return rubber;
}

// Panes on the long sides and the ends, thinner than the recess they stand in: the extents stay the shell's.
void add_panes(std::vector<Mesh>& meshes, const Eigen::Vector3d& size_m, double recess_m, Material glass) {
  const double L = size_m.x(), W = size_m.y(), H = size_m.z(), thickness_m = 0.8 * recess_m;
  glass.accent = 1.5 * kGlass;
  constexpr int kPanes = 9;
  for (const double side : {-1.0, 1.0}) {
    for (int k = 0; k < kPanes; ++k) {  // every third is a door
      const bool door = k % 3 == 1;
      const double at = 0.76 * L * ((k + 0.5) / kPanes - 0.5), height_m = (door ? 0.5 : 0.26) * H;
      append(meshes, block({at, side * (W / 2 - recess_m), 0.79 * H - height_m / 2},
                           {0.06 * L, thickness_m, height_m}, 0, glass));
    }
    append(meshes,
           block({side * (L / 2 - recess_m), 0, 0.68 * H}, {thickness_m, 0.6 * W, 0.24 * H}, 0, glass));
  }
}

}  // namespace

std::vector<Mesh> skateboard(const Eigen::Vector3d& size_m, const Material& material) {
  const Deck deck{size_m};
  Material grip = material;
  std::swap(grip.color, grip.accent);
  std::vector<Mesh> meshes{deck_face(deck, material, false), deck_face(deck, grip, true),
                           deck_rim(deck, material)};
  for (const double end : {-1.0, 1.0})
    append(meshes, truck(size_m, end * 0.29 * size_m.x(), part_material(material, 1, kMetal),
                         part_material(material, 2, kRubber)));
  fit_to_box(meshes, size_m);
  return meshes;
}

std::vector<Mesh> car(const Eigen::Vector3d& size_m, const Material& material) {
  const double L = size_m.x(), W = size_m.y(), H = size_m.z();
  auto meshes = block({0, 0, 0.43 * H}, {L, W, 0.5 * H}, std::min({0.05 * L, 0.15 * W, 0.12 * H}), material);
  append(meshes, frustum({-0.04 * L, 0, 0.83 * H}, {0.62 * L, 0.94 * W}, {0.4 * L, 0.76 * W}, 0.34 * H,
                         part_material(material, 1, kGlass)));
  add_wheels(meshes, 0.3 * L, 0.43 * W, std::min(0.21 * H, 0.08 * L), 0.12 * W, rubber_of(material));
  fit_to_box(meshes, size_m);
  return meshes;
}

std::vector<Mesh> carriage(const Eigen::Vector3d& size_m, const Material& material) {
  const double L = size_m.x(), W = size_m.y(), H = size_m.z();
  const RoundedBoxOptions shell{
      .radius_m = 0.06 * std::min({L, W, H}), .recess_depth_m = 0.02 * W, .recess_share = 0.8};
  auto meshes = rounded_box({L, W, 0.74 * H}, shell, material);
  transform(meshes, {Eigen::Quaterniond::Identity(), {0, 0, 0.58 * H}});
  add_panes(meshes, size_m, shell.recess_depth_m, part_material(material, 3, kGlass));
  const Material metal = part_material(material, 1, kMetal);
  append(meshes,
         block({0, 0, 0.16 * H}, {0.4 * L, 0.8 * W, 0.14 * H}, 0, metal));  // equipment under the floor
  for (const double end : {-0.3, 0.3}) {
    append(meshes, block({end * L, 0, 0.15 * H}, {0.16 * L, 0.7 * W, 0.14 * H}, 0, metal));  // bogie
    append(meshes, block({end * L, 0, 0.965 * H}, {0.2 * L, 0.6 * W, 0.07 * H}, 0, metal));  // roof unit
    for (const double axle : {end - 0.05, end + 0.05})
      for (const double side : {-0.38, 0.38})
        append(meshes, wheel({axle * L, side * W, 0.09 * H}, 0.09 * H, 0.08 * W, rubber_of(material)));
  }
  fit_to_box(meshes, size_m);
  return meshes;
}

}  // namespace uniquadric
