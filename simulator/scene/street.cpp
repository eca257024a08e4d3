#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "core/base/random.h"
#include "simulator/scene/mesh_building.h"
#include "simulator/scene/shapes.h"
#include "simulator/scene/street_parts.h"

namespace uniquadric {
namespace {

using Eigen::Vector3d;

constexpr double kTile_m = 14;  // of ground that one texture covers

/// A part of the street: what makes it, and where it stands.
struct Part {
  std::function<std::vector<Mesh>()> make;
  Pose street_from_part = {};
};

/// The street as it is put together: ground at z = 0, x along, middle at y = 0.
struct Plan {
  const Vector3d& size_m;
  const Material& material;
  std::vector<Part> parts = {};
  std::uint64_t paints = 0;

  double facade_y() const { return size_m.y() / 2 - kHouse_m; }
  double kerb_y() const { return facade_y() - kPavement_m; }
  double facade_x() const { return size_m.x() / 2 - kHouse_m; }
  RandomStream random(std::string_view what, std::uint64_t number) const {
    return {material.seed, what, number};
  }
  /// Paint for the next part; `share` of the body's texture size.
  Material paint(TextureStyle style, const Vector3d& color, double share, int marks) {
    Material result = material;
    result.style = style;
    result.color = color;
    result.accent = 0.55 * color + Vector3d::Constant(0.12);
    result.seed = material.seed * 4096 + ++paints;
    result.size_px = std::max(16, static_cast<int>(material.size_px * share));
    result.marks = marks;
    return result;
  }
  void stand(std::function<std::vector<Mesh>()> make, const Vector3d& at, double yaw_rad) {
    parts.push_back({std::move(make), {exp_so3(yaw_rad * Vector3d::UnitZ()), at}});
  }
};

// All parts in their order; painting them takes the time, which the cores share.
std::vector<Mesh> make_parts(const std::vector<Part>& parts) {
  std::vector<std::vector<Mesh>> made(parts.size());
  tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t i) {
    made[i] = parts[i].make();
    transform(made[i], parts[i].street_from_part);
  });
  std::vector<Mesh> meshes;
  for (std::vector<Mesh>& part : made) append(meshes, std::move(part));
  return meshes;
}

Vector3d muted(RandomStream& random, double low, double high) {
  const double level = random.uniform(low, high);
  const double red = random.uniform(-0.08, 0.1), green = random.uniform(-0.05, 0.05),
               blue = random.uniform(-0.1, 0.08);
  return {level + red, level + green, level + blue};
}

void lay_strip(Plan& plan, double y0, double y1, double z, TextureStyle style, const Vector3d& color,
               int marks) {
  const int tiles = std::max(1, static_cast<int>(std::lround(plan.size_m.x() / kTile_m)));
  for (int k = 0; k < tiles; ++k) {
    const double x0 = plan.size_m.x() * (static_cast<double>(k) / tiles - 0.5),
                 x1 = plan.size_m.x() * ((k + 1.0) / tiles - 0.5);
    Material paint = plan.paint(style, color, 0.5, marks);
    paint.contrast *= 0.6;  // a road is no camouflage
    plan.parts.push_back({[=] {
      Mesh mesh;
      add_quad(mesh, {x0, y0, z}, {x1, y0, z}, {x1, y1, z}, {x0, y1, z});
      mesh.texture = paint_texture(paint, 0, x1 - x0, y1 - y0);
      return std::vector{mesh};
    }});
  }
}

// Edge stones of both pavements: x and y are where those end and lie.
Mesh kerb_stones(double x, double y) {
  Mesh stones;
  for (const double side : {-1.0, 1.0})
    for (double at = -x; at < x; at += 2)
      add_box(stones, {std::min(at + 1, x - 1), side * y, kKerbHeight_m / 2 + 0.01},
              {1.96, 0.24, kKerbHeight_m + 0.02});
  return stones;
}

Mesh lane_dashes(double x, double y) {
  Mesh dashes;
  for (const double lane : {-0.5, 0.0})
    for (double at = -x + 2; at + 3 < x; at += 6) {
      constexpr double kAbove_m = 0.005, kWidth_m = 0.15;
      const double at_y = lane * y;
      add_quad(dashes, {at, at_y - kWidth_m / 2, kAbove_m}, {at + 3, at_y - kWidth_m / 2, kAbove_m},
               {at + 3, at_y + kWidth_m / 2, kAbove_m}, {at, at_y + kWidth_m / 2, kAbove_m});
    }
  return dashes;
}

void mark_ground(Plan& plan) {
  const auto mark = [&](const Mesh& mesh, const Material& paint, double width_m, double height_m) {
    plan.parts.push_back({[=] {
      std::vector<Mesh> meshes{mesh};
      meshes[0].texture = paint_texture(paint, 0, width_m, height_m);
      return meshes;
    }});
  };
  const double x = plan.size_m.x() / 2, y = plan.kerb_y();
  mark(kerb_stones(x, y), plan.paint(TextureStyle::speckle, {0.6, 0.6, 0.58}, 0.125, 4), 2, 0.25);
  mark(lane_dashes(x, y), plan.paint(TextureStyle::speckle, {0.85, 0.85, 0.82}, 0.125, 6), 3, 0.15);
}

void lay_ground(Plan& plan) {
  const double kerb = plan.kerb_y(), wall = plan.size_m.y() / 2;
  const int bands = std::max(1, static_cast<int>(std::lround(2 * kerb / kTile_m)));
  for (int k = 0; k < bands; ++k)
    lay_strip(plan, kerb * (2.0 * k / bands - 1), kerb * (2.0 * (k + 1) / bands - 1), 0,
              TextureStyle::speckle, {0.36, 0.36, 0.38}, 36);
  for (const double side : {-1.0, 1.0})
    lay_strip(plan, std::min(side * kerb, side * wall), std::max(side * kerb, side * wall), kKerbHeight_m,
              TextureStyle::checks, {0.52, 0.5, 0.47}, 20);
  mark_ground(plan);
}

// Houses side by side along a line of `length_m` through `middle`, fronts towards the street's middle.
void build_row(Plan& plan, const Vector3d& middle, double yaw_rad, double length_m, std::uint64_t row) {
  RandomStream random = plan.random("houses", row);
  const int houses = std::max(1, static_cast<int>(std::lround(length_m / 11)));
  const Vector3d along = exp_so3(yaw_rad * Vector3d::UnitZ()) * Vector3d::UnitX();
  constexpr TextureStyle kStyles[] = {TextureStyle::bricks, TextureStyle::panels, TextureStyle::strokes,
                                      TextureStyle::planks};
  for (int k = 0; k < houses; ++k) {
    const double width_m = length_m / houses;
    const double height_m =
        (plan.size_m.z() - middle.z()) * (k == houses / 2 ? 1 : random.uniform(0.55, 0.95));
    const Material wall = plan.paint(kStyles[(k + row) % 4], muted(random, 0.42, 0.68), 0.5, 14);
    const Material trim = plan.paint(TextureStyle::speckle, muted(random, 0.5, 0.75), 0.125, 6);
    const Material glass = plan.paint(TextureStyle::panels, {0.22, 0.3, 0.38}, 0.125, 5);
    plan.stand(
        [=] {
          return building({width_m - 0.05, kHouse_m, height_m}, wall, trim, glass);
        },
        middle + (-length_m / 2 + (k + 0.5) * width_m) * along, yaw_rad);
  }
}

void stand_on_pavement(Plan& plan, int index, double x, double side) {
  RandomStream random = plan.random("pavement", static_cast<std::uint64_t>(2 * index) + (side > 0));
  const double from_kerb_m = random.uniform(1.2, 1.8), along_m = random.uniform(-0.8, 0.8);
  const Vector3d at(x + along_m, side * (plan.kerb_y() + from_kerb_m), kKerbHeight_m);
  const double to_street = side > 0 ? -std::numbers::pi / 2 : std::numbers::pi / 2;
  if (index % 3 == 0) {
    const double height_m = random.uniform(5, 6);
    const Material metal = plan.paint(TextureStyle::panels, {0.35, 0.4, 0.38}, 0.125, 6);
    plan.stand([=] { return street_lamp(height_m, metal); }, at, to_street);
  } else if (index % 3 == 1) {
    const double height_m = random.uniform(4, 6);
    const Material bark = plan.paint(TextureStyle::planks, {0.36, 0.28, 0.2}, 0.125, 8);
    const Material leaves = plan.paint(TextureStyle::speckle, {0.26, 0.42, 0.2}, 0.0625, 7);
    plan.stand([=] { return tree(height_m, bark, leaves); }, at, random.uniform(0, 6));
  } else {
    const Vector3d size_m{random.uniform(1.6, 2.6), random.uniform(1.2, 1.7), random.uniform(2.1, 2.7)};
    const Material walls = plan.paint(TextureStyle::strokes, muted(random, 0.4, 0.6), 0.25, 7);
    const double yaw_rad = random.uniform(-0.15, 0.15);
    const Material roof = plan.paint(TextureStyle::planks, muted(random, 0.3, 0.5), 0.125, 6);
    plan.stand([=] { return kiosk(size_m, walls, roof); }, at, yaw_rad);
  }
}

void park_cars(Plan& plan, double side) {
  RandomStream random = plan.random("parked", side > 0);
  for (double x = -plan.facade_x() + 6; x < plan.facade_x() - 6; x += random.uniform(6.5, 11)) {
    const Vector3d size_m{random.uniform(3.9, 4.8), random.uniform(1.7, 1.85), random.uniform(1.4, 1.8)};
    Material body = plan.paint(TextureStyle::panels, muted(random, 0.25, 0.6), 0.125, 8);
    plan.stand([=] { return car(size_m, body); }, {x, side * (plan.kerb_y() - 1.2), size_m.z() / 2},
               random.uniform(-0.04, 0.04));
  }
}

}  // namespace

std::vector<Mesh> street(const Vector3d& size_m, bool parked_cars, const Material& material) {
  Plan plan{size_m, material};
  lay_ground(plan);
  const double half_turn = std::numbers::pi;
  build_row(plan, {0, plan.facade_y(), kKerbHeight_m}, 0, size_m.x() - 2 * kHouse_m, 0);
  build_row(plan, {0, -plan.facade_y(), kKerbHeight_m}, half_turn, size_m.x() - 2 * kHouse_m, 1);
  build_row(plan, {plan.facade_x(), 0, 0}, -half_turn / 2, size_m.y(), 2);
  build_row(plan, {-plan.facade_x(), 0, 0}, half_turn / 2, size_m.y(), 3);
  for (const double side : {-1.0, 1.0}) {
    int index = side > 0 ? 0 : 1;
    for (double x = -plan.facade_x() + 3; x < plan.facade_x() - 2; x += 5)
      stand_on_pavement(plan, index++, x, side);
    if (parked_cars) park_cars(plan, side);
  }
  std::vector<Mesh> meshes = make_parts(plan.parts);
  fit_to_box(meshes, size_m);
  return meshes;
}

}  // namespace uniquadric
