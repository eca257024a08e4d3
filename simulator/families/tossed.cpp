#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "simulator/families/families.h"
#include "simulator/families/scene_draft.h"

namespace uniquadric {
namespace {

using Eigen::Vector3d;

constexpr double kClearOfWalls_m = 2.4;  // from the middle of the room, whose furniture begins there

// Thrown onto the floor within a metre of the room's middle.
std::string draw_toss(RandomStream& random, const Thing& thing, const FamilyOptions& options) {
  const double direction = random.uniform(-std::numbers::pi, std::numbers::pi);
  const double speed_mps = graded(options.difficulty, 0.4, 2) * random.uniform(0.8, 1.2);
  const double from_m = random.uniform(0.3, 1);
  const double height_m = 0.5 * thing.size_m.norm() + random.uniform(0.3, 1);
  const double spin_degps = graded(options.difficulty, 60, 400);
  const auto spin = [&] { return random.uniform(-spin_degps, spin_degps); };
  // in braces the order of draws is the same for every compiler
  const Vector3d spins{spin(), spin(), spin()};
  const Vector3d rpy_deg{random.uniform(-30, 30), random.uniform(-30, 30), random.uniform(-180, 180)};
  const double up_mps = random.uniform(0, 2);
  const double begins_s = random.uniform(0.2, 0.5) * static_cast<double>(options.frames) / 30;
  const double restitution = random.uniform(0.2, 0.6);
  const double friction = random.uniform(0.25, 0.6);
  return fmt::format(
      "      {{kind: toss, start: {{position_m: {}, rpy_deg: {}}}, velocity_mps: {}, angular_velocity_degps: "
      "{}, begins_s: {}, restitution: {}, friction: {}}}\n",
      yaml_vector({-from_m * std::cos(direction), -from_m * std::sin(direction), height_m}),
      yaml_vector(rpy_deg, 2),
      yaml_vector({speed_mps * std::cos(direction), speed_mps * std::sin(direction), up_mps}),
      yaml_vector(spins, 1), yaml_number(begins_s, 2), yaml_number(restitution, 2), yaml_number(friction, 2));
}

std::string camera_of(RandomStream& random, const FamilyOptions& options) {
  const double far_m = graded(options.difficulty, 1.6, 2.4), begin = random.uniform(-180, 180);
  const double arc_deg = random.below(2) ? random.uniform(10, 60) : 0;  // every other camera stands still
  const double duration_s = options.camera_s();
  std::string text =
      "  motion:\n    kind: spline\n    look_at_m: [0, 0, 0.3]\n    may_overshoot: true\n    waypoints:\n";
  const double above_m = random.uniform(1, 1.5);
  for (int i = 0; i <= 4; ++i) {
    const double share = (i - 0.5) / 3, angle = (begin + share * arc_deg) * std::numbers::pi / 180;
    text += fmt::format("      - {{time_s: {}, position_m: {}}}\n", yaml_number(share * duration_s, 2),
                        yaml_vector({far_m * std::cos(angle), far_m * std::sin(angle), above_m}));
  }
  return text;
}

}  // namespace

std::string tossed_scene(RandomStream& random, const FamilyOptions& options) {
  const int drawn = 1 + static_cast<int>(graded(options.difficulty, 1, 3.99) * random.uniform());
  const int count = options.count > 0 ? options.count : drawn;
  SceneDraft draft(options, camera_of(random, options), 0.01);
  draft.add_world(drawn_room(random));
  draft.keep_within(kClearOfWalls_m);
  for (int k = 0; k < count; ++k) {
    const Thing thing = draw_thing(random, options);
    draft.add_drawn(thing, [&] { return draw_toss(random, thing, options); });
  }
  return draft.text();
}

}  // namespace uniquadric
