#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "simulator/families/families.h"
#include "simulator/families/scene_draft.h"
#include "simulator/scene/carried_motions.h"
#include "simulator/scene/shapes.h"

namespace uniquadric {
namespace {

using Eigen::Vector3d;

// Lanes, y of their middles: the sensor car drives along +x.
constexpr double kEgoLane_m = -2.75, kFastLane_m = 1.2, kOncomingLane_m = 5.4, kCycleLane_m = -6.7;
// Its kerbs, and what stands on the pavements of the primitive `street`: every 5 m, 0.8 m to and fro.
constexpr double kKerb_m = 11;
constexpr double kFirstThing_m = 6, kBetweenThings_m = 5;
constexpr double kWidth_m = 2 * (kKerb_m + kPavement_m + kHouse_m);
constexpr double kFromKerb_m = 0.3;  // of what is parked
constexpr double kCameraHeight_m = 1.65, kClear_m = 0.4, kBehind_m = 25;
constexpr double kHouses_m = 10;    // before each end of the street
constexpr double kCarShare = 0.65;  // of vehicles
constexpr int kMostTries = 60;      // to find a place for an actor
const Vector3d kEgoSize_m(4.5, 1.9, 1.6);

// What a scene's actors are drawn about.
struct Street {
  double duration_s, speed_mps, start_m, length_m;  // the sensor car's; the street's from end to end
  double difficulty;
};

enum class Vehicles { cars, all };

Thing vehicle(RandomStream& random, const Street& street, Vehicles which = Vehicles::all) {
  const double kind = random.uniform() * (which == Vehicles::cars ? kCarShare : 1);
  const auto sized = [&](const Vector3d& least, const Vector3d& most) {
    const double share = random.uniform();
    return Vector3d(least + share * (most - least));
  };
  Thing thing;
  std::string primitive = "rounded_box";
  if (kind < kCarShare) {
    thing.name = primitive = "car";
    thing.size_m = sized({3.9, 1.7, 1.4}, {4.9, 1.9, 1.65});
  } else if (kind < 0.88) {
    thing.name = "van";
    thing.size_m = sized({4.8, 1.9, 1.9}, {6, 2.2, 2.6});
  } else {
    thing.name = "truck";
    thing.size_m = sized({7, 2.4, 2.9}, {11, 2.55, 3.6});
  }
  const bool is_plain = random.uniform() < graded(street.difficulty, 0.3, 1);
  const Vector3d paint = drawn_color(random);
  thing.keys = fmt::format(
      "    primitive: {}\n    size_m: {}\n{}    material: {{color: {}, contrast: {}, texture: {}}}\n",
      primitive, yaml_vector(thing.size_m, 2), primitive == "car" ? "" : "    radius_m: 0.15\n",
      yaml_vector(paint, 2), yaml_number(graded(street.difficulty, 0.4, 0.1), 2),
      is_plain ? "none" : "sparse");
  return thing;
}

Thing walker(RandomStream& random, bool on_wheels) {
  Thing thing;
  thing.name = on_wheels ? "cyclist" : "pedestrian";
  const double height_m = random.uniform(1.55, 1.9);
  thing.size_m = on_wheels ? Vector3d(1.8, 0.6, height_m) : Vector3d(0.7, 0.55, height_m);
  const Vector3d coat = drawn_color(random);
  thing.keys = fmt::format("    primitive: {}\n    size_m: {}\n    material: {{color: {}}}\n", thing.name,
                           yaml_vector(thing.size_m, 2), yaml_vector(coat, 2));
  return thing;
}

struct Drive {
  double speed_mps = 0;
  std::vector<DriveLeg> legs;
};

// Speeds up and slows down now and then.
void drive_on(RandomStream& random, Drive& drive, double speed_mps, double duration_s) {
  while (duration_s > 0) {
    const double lasts_s = random.uniform(1.2, 3);
    const double least = std::max(-3.0, -speed_mps / lasts_s),
                 most = std::min(2.0, (1.4 * drive.speed_mps - speed_mps) / lasts_s);
    const double acceleration = random.uniform(std::min(least, most), most);
    drive.legs.push_back({lasts_s, acceleration});
    speed_mps = std::max(0.0, speed_mps + acceleration * lasts_s);
    duration_s -= lasts_s;
  }
}

// Brakes to rest, waits, and goes again. Returns the time that this takes, and gives the speed after it.
double stop_and_go(RandomStream& random, Drive& drive, double& speed_mps) {
  constexpr double kHardest_mps2 = 5, kSurely_mps2 = 0.01;  // more than rounding in the text takes away
  const double brakes_s = std::max(random.uniform(1, 2), speed_mps / kHardest_mps2),
               waits_s = random.uniform(0.5, 1.5), starts_s = random.uniform(1, 2),
               start_mps2 = random.uniform(1, 2);
  drive.legs.push_back({brakes_s, -speed_mps / brakes_s - kSurely_mps2});
  drive.legs.push_back({waits_s});
  drive.legs.push_back({starts_s, start_mps2});
  speed_mps = start_mps2 * starts_s;
  return brakes_s + waits_s + starts_s;
}

// To another line of the same lane, by as much steering to one side as to the other.
double swerve(RandomStream& random, Drive& drive, double speed_mps) {
  constexpr double kMostTurn_rad = 0.25;
  const double width_m = random.uniform(0.4, 1.2), side = random.below(2) ? 1 : -1;
  const double aside_m = side * width_m;
  const double turns_s = std::max(random.uniform(0.8, 1.5), std::abs(aside_m) / (kMostTurn_rad * speed_mps));
  const double curvature = aside_m / std::pow(speed_mps * turns_s, 2);
  const double steer_rad = std::atan(DriveOptions{}.wheelbase_m * curvature);
  drive.legs.push_back({turns_s, 0, steer_rad});
  drive.legs.push_back({turns_s, 0, -steer_rad});
  return 2 * turns_s;
}

Drive draw_drive(RandomStream& random, double speed_mps, double duration_s) {
  constexpr double kStops = 0.25, kSwerves = 0.5;  // cumulative shares
  Drive drive{speed_mps, {}};
  const double manner = random.uniform();
  if (manner < kSwerves) {
    const double begins_s = random.uniform(0.1, 0.3) * duration_s;
    drive.legs.push_back({begins_s});
    duration_s -= begins_s;
  }
  if (manner < kStops)
    duration_s -= stop_and_go(random, drive, speed_mps);
  else if (manner < kSwerves)
    duration_s -= swerve(random, drive, speed_mps);
  drive_on(random, drive, speed_mps, duration_s);
  return drive;
}

// In so much time.
double way_of(const Drive& drive, double duration_s) {
  double way_m = 0, speed = drive.speed_mps;
  for (const DriveLeg& leg : drive.legs) {
    const double lasts_s = std::clamp(duration_s, 0.0, leg.duration_s), a = leg.acceleration_mps2;
    const double moving_s = a < 0 ? std::min(lasts_s, -speed / a) : lasts_s;
    way_m += (speed + 0.5 * a * moving_s) * moving_s;
    speed = std::max(0.0, speed + a * leg.duration_s);
    duration_s -= leg.duration_s;
  }
  return way_m;
}

std::string legs_text(const Drive& drive) {
  constexpr double kShortest_s = 0.005;  // shorter ones would be written as 0
  std::string text;
  for (const DriveLeg& leg : drive.legs) {
    if (leg.duration_s < kShortest_s) continue;
    text += fmt::format("{}{{duration_s: {}, acceleration_mps2: {}", text.empty() ? "[" : ", ",
                        yaml_number(leg.duration_s, 2), yaml_number(leg.acceleration_mps2, 2));
    const double steer_deg = leg.steer_rad * 180 / std::numbers::pi;
    text += steer_deg == 0 ? "}" : fmt::format(", steer_deg: {}}}", yaml_number(steer_deg, 3));
  }
  return text + "]";
}

std::string drive_text(double x_m, double y_m, double heading_deg, const Drive& drive, double height_m) {
  return fmt::format("kind: drive, start_m: [{}, {}], heading_deg: {}, speed_mps: {}, height_m: {}, legs: {}",
                     yaml_number(x_m, 2), yaml_number(y_m, 2), yaml_number(heading_deg, 2),
                     yaml_number(drive.speed_mps, 2), yaml_number(height_m, 3), legs_text(drive));
}

std::string in_line(const std::string& motion) {
  return "      {" + motion + "}\n";
}

// Along a lane, from `from_m` to `to_m` ahead of the sensor car at the start. Nothing where the way would end
// in the houses.
std::optional<std::string> along_lane(RandomStream& random, const Street& street, const Thing& thing,
                                      double lane_m, double heading_deg, double relative_speed, double from_m,
                                      double to_m) {
  const double x_m = street.start_m + random.uniform(from_m, to_m);
  const double y_m = lane_m + random.uniform(-0.3, 0.3);
  const double speed_mps = street.speed_mps * relative_speed * random.uniform(0.8, 1.2);
  const Drive drive = draw_drive(random, speed_mps, street.duration_s);
  const double end_m = x_m + (heading_deg == 0 ? 1 : -1) * way_of(drive, street.duration_s);
  if (std::abs(end_m) > 0.5 * street.length_m - kHouses_m) return std::nullopt;
  return in_line(drive_text(x_m, y_m, heading_deg, drive, 0.5 * thing.size_m.z()));
}

std::string standing(RandomStream& random, const Street& street, const Thing& thing, double way_m) {
  const double x_m = street.start_m + random.uniform(8, way_m + graded(street.difficulty, 10, 30));
  const double side = random.below(2) ? 1 : -1;
  return fmt::format(
      "      {{kind: static, position_m: {}, rpy_deg: [0, 0, {}]}}\n",
      yaml_vector({x_m, side * (kKerb_m - kFromKerb_m - 0.5 * thing.size_m.y()), 0.5 * thing.size_m.z()}),
      random.below(2) ? 0 : 180);
}

// Where what crosses finds a gap on both pavements.
struct Crossing {
  double reach_m;             // from the street's middle to where it comes from and goes to
  double first_m, between_m;  // of the gaps, from the street's end
};

// Between two things on a pavement, whichever they are.
constexpr Crossing kOnFoot{kKerb_m + 2.5, kFirstThing_m + 0.5 * kBetweenThings_m, kBetweenThings_m};

// A car's width beside a tree: a lamp and a tree on one side, a tree and a kiosk on the other.
Crossing by_car(const Thing& car) {
  return {kKerb_m + kPavement_m - 0.1 - 0.5 * car.size_m.x(), kFirstThing_m + 1.93, 3 * kBetweenThings_m};
}

// Across the street ahead of where the sensor car will be, from pavement to pavement, down and up the kerbs.
std::string across(RandomStream& random, const Street& street, const Thing& thing, const Crossing& crossing,
                   double speed_mps) {
  constexpr int kSteps = 16;
  const double way_m = street.speed_mps * street.duration_s, end_m = -0.5 * street.length_m;
  const double near_m = street.start_m + random.uniform(12, way_m + graded(street.difficulty, 14, 25));
  const double gap = std::round((near_m - end_m - crossing.first_m) / crossing.between_m);
  const double x_m = end_m + crossing.first_m + gap * crossing.between_m;
  const double side = random.below(2) ? 1 : -1;
  const double takes_s = 2 * crossing.reach_m / (speed_mps * random.uniform(0.8, 1.2));
  const double begins_s = random.uniform(-0.5 * takes_s, 0.7 * street.duration_s);
  std::string text = "      kind: spline\n      may_overshoot: true\n      waypoints:\n";
  for (int i = 0; i <= kSteps; ++i) {
    const double share = static_cast<double>(i) / kSteps;
    const double y_m = side * crossing.reach_m * (2 * share - 1);
    const double floor_m = std::abs(y_m) > kKerb_m ? kKerbHeight_m : 0;
    text += fmt::format("        - {{time_s: {}, position_m: {}, rpy_deg: [0, 0, {}]}}\n",
                        yaml_number(begins_s + share * takes_s, 3),
                        yaml_vector({x_m, y_m, floor_m + 0.5 * thing.size_m.z()}), side > 0 ? 90 : -90);
  }
  return text;
}

// One of a kind that is drawn once, however often its place is: else the kinds that soon find a place would
// be more than their share.
void add_actor(RandomStream& random, const Street& street, SceneDraft& draft) {
  const double way_m = street.speed_mps * street.duration_s;
  const double farthest_m =
      std::min(2 * way_m + graded(street.difficulty, 25, 40), street.length_m - kBehind_m - kHouses_m);
  const double ahead_m = graded(street.difficulty, 18, 42);  // of who drives the same way
  const auto add_along = [&](const Thing& thing, double lane_m, double heading_deg, double relative_speed,
                             double from_m, double to_m) {
    draft.add_drawn(
        thing,
        [&] { return along_lane(random, street, thing, lane_m, heading_deg, relative_speed, from_m, to_m); },
        kMostTries);
  };
  const auto add_across = [&](const Thing& thing, const Crossing& crossing, double speed_mps) {
    draft.add_drawn(
        thing, [&] { return across(random, street, thing, crossing, speed_mps); }, kMostTries);
  };
  const double kind = random.uniform();
  if (kind < 0.22) {
    add_along(vehicle(random, street), kEgoLane_m, 0, 1, 9, ahead_m);
  } else if (kind < 0.42) {
    add_along(vehicle(random, street), kFastLane_m, 0, 1.3, -16, 0.5 * ahead_m);
  } else if (kind < 0.6) {
    add_along(vehicle(random, street), kOncomingLane_m, 180, 1, 20, farthest_m);
  } else if (kind < 0.72) {
    const Thing thing = vehicle(random, street);
    draft.add_drawn(
        thing, [&] { return standing(random, street, thing, way_m); }, kMostTries);
  } else if (kind < 0.8) {
    const Thing car = vehicle(random, street, Vehicles::cars);
    add_across(car, by_car(car), 6);
  } else if (kind < 0.9) {
    add_along(walker(random, true), kCycleLane_m, 0, 0.5, 5, ahead_m);
  } else {
    add_across(walker(random, false), kOnFoot, 1.4);
  }
}

std::string sensors(RandomStream& random, const FamilyOptions& options) {
  const std::string pattern = options.lidar.empty()
                                  ? one_of<std::string>(random, {"livox_avia", "hdl64e", "os1_64", "vlp16"})
                                  : options.lidar;
  return fmt::format(
      "imu: {{rate_hz: 200, body_from_imu: {{position_m: [-0.05, 0.02, -0.08]}}}}\n"
      "lidar: {{pattern: {}, rate_hz: 10, body_from_lidar: {{position_m: [-0.1, 0, 0.25]}}}}\n"
      "light: {{sun_direction: [0.6, 0.35, -0.7], ambient: 0.6, sky_color: [0.62, 0.74, 0.88]}}\n"
      "map: {{resolution_m: 0.2}}\n",
      pattern);
}

}  // namespace

std::string street_scene(RandomStream& random, const FamilyOptions& options) {
  Street street{static_cast<double>(options.frames) / 30, graded(options.difficulty, 3, 12), 0, 0,
                options.difficulty};
  const double way_m = street.speed_mps * street.duration_s;
  street.length_m = std::round(10 * std::max(110.0, 1.4 * way_m + 80)) / 10;  // as it is written
  street.start_m = -0.5 * street.length_m + kBehind_m;
  const Drive drive = draw_drive(random, street.speed_mps, street.duration_s);
  const auto ego = [&](double height_m) {
    return drive_text(street.start_m, kEgoLane_m, 0, drive, height_m);
  };
  const std::string camera = fmt::format(
      "  calibration: {{width: 640, height: 480, fx: 460, fy: 460, cx: 319.5, cy: 239.5}}\n  depth: false\n"
      "  motion:\n    kind: compose\n    parts:\n      - {{{}}}\n      - {{kind: tremor, position_m: 0.0004, "
      "rotation_deg: 0.05, seed: {}}}\n",
      ego(kCameraHeight_m), random.below(100'000));
  SceneDraft draft(options, camera, kClear_m);
  draft.keep_clear_of("{" + ego(0.5 * kEgoSize_m.z()) + "}", kEgoSize_m, false);
  draft.add_world(
      fmt::format("  - {{name: street, primitive: street, size_m: [{}, {}, 14], parked_cars: false, "
                  "material: {{seed: {}, texture: sparse}}}}\n",
                  yaml_number(street.length_m, 1), yaml_number(kWidth_m, 1), random.below(100'000)));
  const int drawn = 1 + static_cast<int>(graded(options.difficulty, 3, 9.99) * random.uniform());
  const int count = options.count > 0 ? options.count : drawn;
  // who finds no place is left out, unless nobody else does
  for (int i = 0; i < count || (draft.count() == 0 && i < kMostTries); ++i) add_actor(random, street, draft);
  return sensors(random, options) + draft.text();
}

}  // namespace uniquadric
