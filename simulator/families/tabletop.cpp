#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "simulator/families/families.h"

namespace uniquadric {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kTable_m[] = {1.5, 1.0, 0.72};
constexpr double kClear_m = 0.01;  // between what things can sweep
constexpr int kMostTries = 300;    // of places for one thing
constexpr double kPushedShare = 0.4, kLiftedShare = 0.3;

enum class Act { rest, push, lift };

struct Thing {
  std::string name, primitive, extra;
  Vector3d size_m;
  Act act = Act::rest;
  Vector2d from_m, to_m;
  double yaw_deg = 0, turn_deg = 0;

  // Of the circle that its foot stays within, however it turns about the vertical.
  double reach_m() const { return 0.5 * size_m.head<2>().norm(); }
  double z_m() const { return kTable_m[2] + 0.5 * size_m.z(); }
};

Thing draw_thing(RandomStream& random, int id) {
  const std::string kind = one_of<std::string>(random, {"box", "can", "book", "block", "bottle"});
  const auto between = [&](double low, double high) { return random.uniform(low, high); };
  Thing thing;
  thing.name = fmt::format("{}_{}", kind, id);
  thing.primitive = kind == "can" || kind == "bottle" ? "cylinder" : "rounded_box";
  if (kind == "box") thing.size_m = {between(0.12, 0.20), between(0.05, 0.09), between(0.16, 0.28)};
  if (kind == "book") thing.size_m = {between(0.18, 0.28), between(0.12, 0.20), between(0.02, 0.05)};
  if (kind == "block") thing.size_m = {between(0.06, 0.16), between(0.06, 0.16), between(0.05, 0.14)};
  if (thing.primitive == "cylinder") {
    const double across = kind == "can" ? between(0.06, 0.10) : between(0.05, 0.08);
    thing.size_m = {across, across, kind == "can" ? between(0.08, 0.14) : between(0.18, 0.28)};
  } else {
    thing.extra = fmt::format("radius_m: {}\n    ", yaml_number(0.03 * thing.size_m.minCoeff()));
  }
  for (double& extent : thing.size_m) extent = std::round(1e4 * extent) / 1e4;  // as it is written
  return thing;
}

Vector2d draw_place(RandomStream& random, double reach_m) {
  const Vector2d free(0.5 * kTable_m[0] - reach_m - 0.05, 0.5 * kTable_m[1] - reach_m - 0.05);
  const double x = random.uniform(-free.x(), free.x());
  return {x, random.uniform(-free.y(), free.y())};
}

// Of two straight stretches of a plane: the least over the ends, or 0 where they cross.
double distance_between(const Vector2d& a0, const Vector2d& a1, const Vector2d& b0, const Vector2d& b1) {
  const auto to_stretch = [](const Vector2d& p, const Vector2d& q0, const Vector2d& q1) {
    const Vector2d along = q1 - q0;
    const double squared = along.squaredNorm();
    const double share = squared > 0 ? std::clamp((p - q0).dot(along) / squared, 0.0, 1.0) : 0.0;
    return (p - q0 - share * along).norm();
  };
  const auto side = [](const Vector2d& p, const Vector2d& q0, const Vector2d& q1) {
    const Vector2d a = q1 - q0, b = p - q0;
    return a.x() * b.y() - a.y() * b.x();
  };
  if (side(a0, b0, b1) * side(a1, b0, b1) < 0 && side(b0, a0, a1) * side(b1, a0, a1) < 0) return 0;
  return std::min(
      {to_stretch(a0, b0, b1), to_stretch(a1, b0, b1), to_stretch(b0, a0, a1), to_stretch(b1, a0, a1)});
}

bool is_clear(const Thing& thing, const std::vector<Thing>& others) {
  return std::ranges::all_of(others, [&](const Thing& other) {
    return distance_between(thing.from_m, thing.to_m, other.from_m, other.to_m) >
           thing.reach_m() + other.reach_m() + kClear_m;
  });
}

// Nobody meets what another sweeps, at any time.
std::optional<Thing> place(RandomStream& random, Thing thing, const std::vector<Thing>& others,
                           double difficulty) {
  for (int i = 0; i < kMostTries; ++i) {
    thing.from_m = thing.to_m = draw_place(random, thing.reach_m());
    if (thing.act != Act::rest) thing.to_m = draw_place(random, thing.reach_m());
    const double way_m = (thing.to_m - thing.from_m).norm();
    const bool is_usual = thing.act == Act::rest || (way_m > 0.08 && way_m < graded(difficulty, 0.25, 0.5));
    if (is_usual && is_clear(thing, others)) return thing;
  }
  return std::nullopt;
}

std::string waypoint(double time_s, const Vector2d& at_m, double z_m, const Vector3d& rpy_deg,
                     double hold_s = 0) {
  return fmt::format("        - {{time_s: {}, position_m: {}, rpy_deg: {}{}}}\n", yaml_number(time_s, 2),
                     yaml_vector({at_m.x(), at_m.y(), z_m}), yaml_vector(rpy_deg, 2),
                     hold_s > 0 ? fmt::format(", hold_s: {}", yaml_number(hold_s, 2)) : "");
}

std::string motion_of(RandomStream& random, const Thing& thing, const FamilyOptions& options) {
  const double z_m = thing.z_m();
  const Vector3d start(0, 0, thing.yaw_deg);
  if (thing.act == Act::rest)
    return fmt::format("    motion: {{kind: static, position_m: {}, rpy_deg: {}}}\n",
                       yaml_vector({thing.from_m.x(), thing.from_m.y(), z_m}), yaml_vector(start, 2));
  const double duration_s = static_cast<double>(options.frames - 1) / 30;
  const double speed_mps = graded(options.difficulty, 0.06, 0.3) * random.uniform(0.8, 1.2);
  const double way_m = (thing.to_m - thing.from_m).norm();
  const double rise_m = thing.act == Act::lift ? random.uniform(0.12, 0.3) : 0;
  const double takes_s = std::clamp((way_m + 2 * rise_m) / speed_mps, 0.6, std::max(0.6, 0.6 * duration_s));
  const double begins_s = random.uniform(0.1, 0.9) * std::max(0.0, duration_s - takes_s);
  const Vector3d end(0, 0, thing.yaw_deg + thing.turn_deg);
  std::string text = "    motion:\n      kind: spline\n      waypoints:\n";
  text += waypoint(begins_s, thing.from_m, z_m, start);
  if (thing.act == Act::lift) {
    const double tilt = graded(options.difficulty, 15, 70);
    const Vector3d tilted(random.uniform(-tilt, tilt), random.uniform(-0.5, 0.5) * tilt,
                          thing.yaw_deg + 0.5 * thing.turn_deg);
    // at its steepest a body reaches half its diagonal below its middle
    const double above_m = kTable_m[2] + 0.5 * thing.size_m.norm() + rise_m;
    text += waypoint(begins_s + 0.5 * takes_s, 0.5 * (thing.from_m + thing.to_m), above_m, tilted,
                     random.uniform(0, 0.15) * takes_s);
    text += waypoint(begins_s + takes_s * 1.2, thing.to_m, z_m, end);
  } else {
    text += waypoint(begins_s + takes_s, thing.to_m, z_m, end);
  }
  return text;
}

// A hand-held arc about the middle of the table.
std::string camera_of(RandomStream& random, const FamilyOptions& options) {
  const double far_m = graded(options.difficulty, 1.0, 1.6),
               duration_s = static_cast<double>(options.frames) / 30;
  const double begin_deg = random.uniform(-180, 180),
               arc_deg = random.uniform(40, 110) * (random.below(2) ? 1 : -1);
  constexpr int kPoints = 6;
  std::string text = "camera:\n  motion:\n    kind: spline\n    look_at_m: [0, 0, 0.78]\n    waypoints:\n";
  for (int i = 0; i <= kPoints; ++i) {
    const double share = (i - 0.5) / (kPoints - 1);
    const double angle = (begin_deg + share * arc_deg) * std::numbers::pi / 180;
    const double away_m = far_m * random.uniform(0.94, 1.06);
    text += fmt::format("      - {{time_s: {}, position_m: {}, roll_deg: {}}}\n",
                        yaml_number(share * duration_s, 2),
                        yaml_vector({away_m * std::cos(angle), away_m * std::sin(angle),
                                     kTable_m[2] + random.uniform(0.45, 0.8)}),
                        yaml_number(random.uniform(-4, 4), 2));
  }
  return text;
}

}  // namespace

std::string tabletop_scene(RandomStream& random, const FamilyOptions& options) {
  const int drawn = 2 + static_cast<int>(graded(options.difficulty, 1, 7) * random.uniform());
  const int count = options.count > 0 ? options.count : drawn;
  std::string text = camera_of(random, options);
  text += fmt::format(
      "world:\n  - {{name: room, primitive: room, size_m: [6, 6, 3], furniture: 8, material: {{seed: "
      "{}}}}}\n",
      random.below(100'000));
  text += fmt::format(
      "  - {{name: table, primitive: rounded_box, size_m: {}, radius_m: 0.01, pose: {{position_m: [0, 0, "
      "{}]}}, material: {}}}\n",
      yaml_vector({kTable_m[0], kTable_m[1], kTable_m[2]}), yaml_number(0.5 * kTable_m[2]),
      drawn_material(random, options.difficulty));
  text += "objects:\n";
  std::vector<Thing> things;
  for (int id = 1; id <= count; ++id) {
    Thing thing = draw_thing(random, id);
    const double act = random.uniform();
    if (act < kPushedShare + kLiftedShare || id == 1)  // something moves
      thing.act = act < kPushedShare ? Act::push : Act::lift;
    thing.yaw_deg = random.uniform(-180, 180);
    thing.turn_deg = random.uniform(-1, 1) * graded(options.difficulty, 30, 120);
    const auto placed = place(random, thing, things, options.difficulty);
    if (!placed) continue;  // the table is full
    things.push_back(*placed);
    text += fmt::format("  - id: {}\n    name: {}\n    primitive: {}\n    {}size_m: {}\n    material: {}\n",
                        id, thing.name, thing.primitive, thing.extra, yaml_vector(thing.size_m),
                        drawn_material(random, options.difficulty));
    text += motion_of(random, *placed, options);
  }
  return text;
}

}  // namespace uniquadric
