#include "simulator/families/table.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace uniquadric {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

Vector2d free_half_m(const Thing& thing) {
  return 0.5 * kTable_m.head<2>() - Vector2d::Constant(thing.reach_m() + 0.05);
}

}  // namespace

void add_room_with_table(RandomStream& random, const FamilyOptions& options, SceneDraft& draft) {
  draft.add_world(drawn_room(random));
  draft.add_world(fmt::format(
      "  - {{name: table, primitive: rounded_box, size_m: {}, radius_m: 0.01, pose: {{position_m: [0, 0, "
      "{}]}}, "
      "material: {}}}\n",
      yaml_vector(kTable_m), yaml_number(0.5 * kTable_m.z()), drawn_material(random, options.difficulty)));
}

Vector2d place_on_table(RandomStream& random, const Thing& thing) {
  const Vector2d half = free_half_m(thing);
  const double x = random.uniform(-half.x(), half.x());
  return {x, random.uniform(-half.y(), half.y())};
}

Vector2d onto_table(const Thing& thing, const Vector2d& at_m) {
  const Vector2d half = free_half_m(thing);
  return at_m.cwiseMax(-half).cwiseMin(half);
}

std::string hand_held_camera(RandomStream& random, const FamilyOptions& options, double arc_deg) {
  constexpr int kPoints = 6;
  const double far_m = graded(options.difficulty, 1.0, 1.6);
  const double duration_s = options.camera_s();
  const double begin_deg = random.uniform(-180, 180), signed_deg = arc_deg * (random.below(2) ? 1 : -1);
  std::string text =
      "  motion:\n    kind: compose\n    parts:\n      - kind: spline\n        look_at_m: [0, 0, 0.78]\n     "
      "   may_overshoot: true\n"
      "        waypoints:\n";
  for (int i = 0; i <= kPoints; ++i) {
    const double share = (i - 0.5) / (kPoints - 1);
    const double angle = (begin_deg + share * signed_deg) * std::numbers::pi / 180;
    const double away_m = far_m * random.uniform(0.94, 1.06);
    const double above_m = kTable_m.z() + random.uniform(0.45, 0.8);
    text += fmt::format("          - {{time_s: {}, position_m: {}, roll_deg: {}}}\n",
                        yaml_number(share * duration_s, 2),
                        yaml_vector({away_m * std::cos(angle), away_m * std::sin(angle), above_m}),
                        yaml_number(random.uniform(-4, 4), 2));
  }
  return text + drawn_camera_tremor(random);
}

std::string static_motion_text(const Vector3d& at_m, const Vector3d& rpy_deg) {
  return fmt::format("      {{kind: static, position_m: {}, rpy_deg: {}}}\n", yaml_vector(at_m),
                     yaml_vector(rpy_deg, 2));
}

std::string waypoint_text(double time_s, const Vector3d& at_m, const Vector3d& rpy_deg, double hold_s) {
  return fmt::format("        - {{time_s: {}, position_m: {}, rpy_deg: {}{}}}\n", yaml_number(time_s, 2),
                     yaml_vector(at_m), yaml_vector(rpy_deg, 2),
                     hold_s >= 0.01 ? fmt::format(", hold_s: {}", yaml_number(hold_s, 2)) : "");
}

}  // namespace uniquadric
