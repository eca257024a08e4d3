#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "simulator/families/families.h"
#include "simulator/families/table.h"

namespace uniquadric {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kPushedShare = 0.4, kLiftedShare = 0.3;
constexpr double kPutDown = 1.2;  // times as long as a push a lift takes

enum class Act { rest, push, lift };

struct Way {
  Vector2d from_m, to_m;
  double yaw_deg = 0, turn_deg = 0;
};

Way draw_way(RandomStream& random, const Thing& thing, Act act, double difficulty) {
  Way way;
  way.from_m = way.to_m = place_on_table(random, thing);
  way.yaw_deg = random.uniform(-180, 180);
  if (act == Act::rest) return way;
  const double direction = random.uniform(-std::numbers::pi, std::numbers::pi);
  const double length_m = random.uniform(0.08, graded(difficulty, 0.25, 0.5));
  way.to_m = onto_table(thing, way.from_m + length_m * Vector2d(std::cos(direction), std::sin(direction)));
  way.turn_deg = random.uniform(-1, 1) * graded(difficulty, 30, 120);
  return way;
}

std::string motion_of(RandomStream& random, const Thing& thing, Act act, const Way& way,
                      const FamilyOptions& options) {
  const double z_m = kTable_m.z() + 0.5 * thing.size_m.z();
  const Vector3d start(0, 0, way.yaw_deg), end(0, 0, way.yaw_deg + way.turn_deg);
  const auto on_table = [&](const Vector2d& at_m) { return Vector3d(at_m.x(), at_m.y(), z_m); };
  if (act == Act::rest) return static_motion_text(on_table(way.from_m), start);
  const double duration_s = static_cast<double>(options.frames - 1) / 30;
  const double speed_mps = graded(options.difficulty, 0.06, 0.3) * random.uniform(0.8, 1.2);
  const double way_m = (way.to_m - way.from_m).norm();
  const double rise_m = act == Act::lift ? random.uniform(0.12, 0.3) : 0;
  const double takes_s = std::clamp((way_m + 2 * rise_m) / speed_mps, 0.6, std::max(0.6, 0.6 * duration_s));
  const double ends_after_s = act == Act::lift ? kPutDown * takes_s : takes_s;
  const double begins_s = random.uniform(0.1, 0.9) * std::max(0.0, duration_s - ends_after_s);
  std::string text = kSplineHead;
  text += waypoint_text(begins_s, on_table(way.from_m), start);
  if (act == Act::push) return text + waypoint_text(begins_s + takes_s, on_table(way.to_m), end);
  const double tilt = graded(options.difficulty, 15, 70);
  const Vector3d tilted{random.uniform(-tilt, tilt), random.uniform(-0.5, 0.5) * tilt,
                        way.yaw_deg + 0.5 * way.turn_deg};
  const Vector2d middle_m = 0.5 * (way.from_m + way.to_m);
  // at its steepest a body reaches half its diagonal below its middle
  const double above_m = kTable_m.z() + 0.5 * thing.size_m.norm() + rise_m;
  text += waypoint_text(begins_s + 0.5 * takes_s, {middle_m.x(), middle_m.y(), above_m}, tilted,
                        random.uniform(0, 0.15) * takes_s);
  return text + waypoint_text(begins_s + ends_after_s, on_table(way.to_m), end);
}

Act draw_act(RandomStream& random, bool must_move) {
  const double act = random.uniform() * (must_move ? kPushedShare + kLiftedShare : 1);
  return act < kPushedShare ? Act::push : act < kPushedShare + kLiftedShare ? Act::lift : Act::rest;
}

}  // namespace

std::string tabletop_scene(RandomStream& random, const FamilyOptions& options) {
  const int drawn = 2 + static_cast<int>(graded(options.difficulty, 1, 7) * random.uniform());
  const int count = options.count > 0 ? options.count : drawn;
  SceneDraft draft(options, hand_held_camera(random, options, random.uniform(40, 110)), 0.01);
  add_room_with_table(random, options, draft);
  for (int k = 0; k < count; ++k) {
    const Thing thing = draw_thing(random, options);
    const Act act = draw_act(random, draft.count() == 0);  // something moves
    draft.add_drawn(thing, [&] {
      const Way way = draw_way(random, thing, act, options.difficulty);
      return motion_of(random, thing, act, way, options);
    });
  }
  return draft.text();
}

}  // namespace uniquadric
