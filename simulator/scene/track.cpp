#include <cmath>

#include "simulator/scene/mesh_building.h"
#include "simulator/scene/shapes.h"
#include "simulator/scene/street_parts.h"

namespace uniquadric {
namespace {

constexpr double kRailWidth_m = 0.08, kRailHeight_m = 0.14, kSleeper_m = 0.65;

// A strip of the ring between two radii at one height, facing up; or a wall of a rail where they are equal.
void add_arc(Mesh& mesh, const TrackOptions& o, int cells, double inner_m, double outer_m, double low_m,
             double high_m) {
  add_grid(mesh, 1, cells, [&](int i, int j) {
    const double angle = o.from_rad + (o.to_rad - o.from_rad) * j / cells;
    const double radius = i == 0 ? outer_m : inner_m;
    const Eigen::Vector3d out(std::cos(angle), std::sin(angle), 0);
    const Eigen::Vector3d across(0, 0, high_m - low_m);
    const Eigen::Vector3d run(-out.y(), out.x(), 0);
    const Eigen::Vector3d side = (inner_m - outer_m) * out + across;
    return Vertex{radius * out + Eigen::Vector3d(0, 0, i == 0 ? low_m : high_m),
                  run.cross(side).normalized(),
                  {j % 2 == 0 ? 0.0 : 1.0, static_cast<double>(i)}};
  });
}

}  // namespace

std::vector<Mesh> track(const TrackOptions& o, const Material& material) {
  const double length_m = o.radius_m * (o.to_rad - o.from_rad);
  const int cells = std::max(1, static_cast<int>(length_m / kSleeper_m));
  Mesh rails, sleepers;
  for (const double middle : {o.radius_m - o.gauge_m / 2, o.radius_m + o.gauge_m / 2}) {
    const double inner = middle - kRailWidth_m / 2, outer = middle + kRailWidth_m / 2;
    add_arc(rails, o, cells, inner, outer, kRailHeight_m, kRailHeight_m);
    add_arc(rails, o, cells, outer, outer, 0, kRailHeight_m);
    add_arc(rails, o, cells, inner, inner, kRailHeight_m, 0);
  }
  for (int k = 0; k < cells; ++k) {
    std::vector<Mesh> sleeper(1);
    add_box(sleeper[0], {o.radius_m, 0, 0.02}, {1.7 * o.gauge_m, 0.26, 0.04});
    const double angle = o.from_rad + (o.to_rad - o.from_rad) * (k + 0.5) / cells;
    transform(sleeper, {exp_so3(angle * Eigen::Vector3d::UnitZ()), Eigen::Vector3d::Zero()});
    merge(sleepers, sleeper[0]);
  }
  rails.texture = paint_texture(material, 0, kSleeper_m, kRailHeight_m);
  sleepers.texture = paint_texture(material, 1, 1.7 * o.gauge_m, 0.26);
  return {rails, sleepers};
}

}  // namespace uniquadric
