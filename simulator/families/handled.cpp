#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simulator/families/families.h"
#include "simulator/families/table.h"

namespace uniquadric {
namespace {

using Eigen::Vector3d;

// ours: a spline from rest to rest is solved for at once, which fails or takes long for hundreds of
// way-points
constexpr int kStopsToRest = 40;
constexpr double kRest_s = 0.1;
constexpr double kGrip_m = 0.02;                                      // ours: of a hand, inside what it holds
constexpr double kUsualWay_m = 0.4, kScreen_m[] = {0.45, 0.04, 0.4};  // hides what is put away behind it

// The hand at its lower side, whose fingers reach about it. It moves with the object.
std::string held_by_hand(RandomStream& random, const Thing& thing, double hand_m, const std::string& motion) {
  const double side = random.below(2) ? 1 : -1;
  const double apart_m = 0.5 * (thing.size_m.y() + hand_m) - std::min(kGrip_m, 0.5 * thing.size_m.y());
  const Vector3d at_m(0, side * apart_m, -0.35 * thing.size_m.z());
  return motion + fmt::format("        - {{kind: static, position_m: {}, rpy_deg: [{}, 0, {}]}}\n",
                              yaml_vector(at_m), yaml_number(random.uniform(-40, 10), 1), side > 0 ? 0 : 180);
}

// The limb behind another one along its y, which bends at the joint between them.
std::string bends_behind(RandomStream& random, const Thing& behind, const Thing& before,
                         const std::string& motion) {
  const double phase_deg = random.uniform(0, 360), period_s = random.uniform(0.8, 2);
  const double amplitude_deg = random.uniform(5, 20), bend_deg = random.uniform(60, 100);
  return motion + fmt::format(
                      "        - {{kind: static, position_m: [0, {}, 0], rpy_deg: [{}, 0, 0]}}\n"
                      "        - {{kind: swing, pivot_m: [0, 0, 0], length_m: {}, amplitude_deg: {}, "
                      "period_s: {}, phase_deg: {}}}\n",
                      yaml_number(0.45 * before.size_m.y()), yaml_number(bend_deg, 1),
                      yaml_number(0.45 * behind.size_m.z()), yaml_number(amplitude_deg, 1),
                      yaml_number(period_s, 2), yaml_number(phase_deg, 1));
}

std::string carried(RandomStream& random, const std::string& waypoints, const FamilyOptions& options) {
  return fmt::format(
      "      kind: compose\n      parts:\n        - kind: spline\n          may_overshoot: true\n          "
      "waypoints:\n{}        - {{kind: "
      "tremor, position_m: {}, rotation_deg: {}, seed: {}}}\n",
      waypoints, yaml_number(graded(options.difficulty, 0.0005, 0.003)),
      yaml_number(graded(options.difficulty, 0.2, 1), 2), random.below(100'000));
}

// Of bare skin.
Thing limb(const std::string& name, const std::string& primitive, const Vector3d& size_m) {
  return {name,
          fmt::format("    primitive: {}\n    size_m: {}\n    material: {{color: [0.72, 0.55, 0.45], accent: "
                      "[0.6, 0.42, 0.35], contrast: 0.1, texture: none}}\n",
                      primitive, yaml_vector(size_m)),
          size_m};
}

// A hand and a forearm that bends at the wrist: seen and not scored, so that something not rigid touches what
// is.
void add_arm(RandomStream& random, const Thing& thing, const std::string& motion, SceneDraft& draft) {
  const Thing hand = limb("hand", "ellipsoid", {0.085, 0.13, 0.045});  // sizes: ours, about a man's
  const Thing forearm = limb("forearm", "cylinder", {0.075, 0.075, 0.28});
  const std::string held = held_by_hand(random, thing, hand.size_m.y(), motion);
  draft.add_unscored(hand, held);
  draft.add_unscored(forearm, bends_behind(random, forearm, hand, held));
}

// A look is its seed's, which by default is each object's own.
void give_look(Thing& thing, int seed) {
  const std::string material = "material: {";
  if (const std::size_t at = thing.keys.find(material); at != std::string::npos)
    thing.keys.insert(at + material.size(), fmt::format("seed: {}, ", seed));
}

std::string stop_text(double time_s, const Vector3d& at_m, const Vector3d& rpy_deg, double hold_s) {
  return "    " + waypoint_text(time_s, at_m, rpy_deg, hold_s).substr(2);
}

// About its own part of the table; now and then behind the screen, over its upper edge, or out of sight.
std::vector<Vector3d> draw_stops(RandomStream& random, const Thing& thing, const Vector3d& home_m,
                                 const FamilyOptions& options) {
  const double away = graded(options.difficulty, 0.1, 0.35), half_m = 0.5 * thing.size_m.norm();
  const double over_m = kTable_m.z() + kScreen_m[2] + half_m + 0.06;
  const Vector3d near{random.uniform(-0.12, 0.12), random.uniform(-0.12, 0.12), random.uniform(0, 0.12)};
  const double event = random.uniform();
  if (event < away) {
    const Vector3d over(home_m.x(), 0.12, over_m), behind(home_m.x(), 0.2 + half_m, home_m.z());
    return {over, behind, over, home_m + near};
  }
  const double side_m = home_m.x() < 0 ? -1.6 : 1.6;
  if (event > 1 - 0.5 * away) return {{side_m, home_m.y(), home_m.z()}, home_m + near};
  return {home_m + near};
}

// It turns on all the way, but for the rests of a long one.
std::string draw_motion(RandomStream& random, const Thing& thing, const Vector3d& home_m,
                        const FamilyOptions& options) {
  const double duration_s = static_cast<double>(options.frames) / 30;
  const double leg_s = graded(options.difficulty, 2.2, 1.0), turn_deg = graded(options.difficulty, 20, 75);
  std::string text;
  Vector3d rpy_deg(0, 0, random.uniform(-180, 180));
  Vector3d at_m = home_m;
  double time_s = -1.5 * leg_s;
  int stops = 0;
  while (time_s < duration_s + leg_s)
    for (const Vector3d& stop_m : draw_stops(random, thing, home_m, options)) {
      time_s += leg_s * (0.5 + (stop_m - at_m).norm() / kUsualWay_m);  // far ways take longer
      at_m = stop_m;
      text += stop_text(time_s, at_m, rpy_deg, ++stops % kStopsToRest == 0 ? kRest_s : 0);
      rpy_deg +=
          turn_deg * Vector3d{random.uniform(-0.5, 0.5), random.uniform(-0.4, 0.4), random.uniform(-1, 1)};
      rpy_deg.y() = std::clamp(rpy_deg.y(), -60.0, 60.0);  // clear of the gimbal's lock
    }
  return carried(random, text, options);
}

std::string box_at(const Vector3d& at_m) {
  return fmt::format("{{kind: static, position_m: {}}}", yaml_vector(at_m));
}

// In front of the table, at arm's length, hardly moving.
std::string camera_before_table(RandomStream& random, const FamilyOptions& options) {
  const double far_m = graded(options.difficulty, 1.1, 1.5), side_m = random.uniform(-0.3, 0.3);
  const double end_m = side_m + random.uniform(-0.3, 0.3);
  const double end_far_m = far_m * random.uniform(0.9, 1.1);
  const double duration_s = static_cast<double>(options.frames) / 30;
  return fmt::format(
      "  motion:\n    kind: compose\n    parts:\n      - kind: spline\n        look_at_m: [0, 0, 0.95]\n"
      "        waypoints:\n          - {{time_s: -1, position_m: {}}}\n          - {{time_s: {}, position_m: "
      "{}}}\n{}",
      yaml_vector({side_m, -far_m, 1.25}), yaml_number(duration_s + 1, 2),
      yaml_vector({end_m, -end_far_m, 1.3}), drawn_camera_tremor(random));
}

}  // namespace

std::string handled_scene(RandomStream& random, const FamilyOptions& options) {
  const int drawn = 1 + static_cast<int>(graded(options.difficulty, 0.8, 3) * random.uniform());
  const int count = options.count > 0 ? options.count : drawn;
  SceneDraft draft(options, camera_before_table(random, options), 0.01);
  add_room_with_table(random, options, draft);
  const Vector3d screen_m(std::min(kScreen_m[0] * count, kTable_m.x()), kScreen_m[1], kScreen_m[2]);
  const Vector3d screen_at_m(0, 0.12, kTable_m.z() + 0.5 * screen_m.z());
  draft.add_world(fmt::format(
      "  - {{name: screen, primitive: box, size_m: {}, pose: {{position_m: {}}}, material: {}}}\n",
      yaml_vector(screen_m), yaml_vector(screen_at_m), drawn_material(random, options.difficulty)));
  draft.keep_clear_of(box_at(screen_at_m), screen_m);
  draft.keep_clear_of(box_at({0, 0, 0.5 * kTable_m.z()}), kTable_m);
  Thing thing;
  for (int k = 0; k < count; ++k) {
    const bool is_twin = k > 0 && random.uniform() < 0.5;  // of the one before
    if (!is_twin) {
      thing = draw_thing(random, options);
      give_look(thing, draft.next_id());
    }
    const double x_m = count > 1 ? -0.45 + 0.9 * k / (count - 1) : 0;
    const Vector3d home_m(x_m, -0.3, kTable_m.z() + 0.5 * thing.size_m.norm() + 0.2);
    const auto motion = draft.add_drawn(thing, [&] { return draw_motion(random, thing, home_m, options); });
    if (motion) add_arm(random, thing, *motion, draft);
  }
  return draft.text();
}

}  // namespace uniquadric
