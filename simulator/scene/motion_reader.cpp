#include "simulator/scene/motion_reader.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>

#include "core/base/config.h"
#include "core/base/error.h"
#include "simulator/scene/bounds.h"
#include "simulator/scene/carried_motions.h"
#include "simulator/scene/contact.h"
#include "simulator/scene/named_motions.h"
#include "simulator/scene/pose_reader.h"
#include "simulator/scene/shape_reader.h"
#include "simulator/scene/spline_reader.h"
#include "simulator/scene/toss.h"

namespace uniquadric {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

Vector3d read_direction(const ConfigNode& node, const std::string& key, const Vector3d& fallback) {
  const auto value = node.find(key);
  if (!value) return fallback;
  const Vector3d direction = value->as<Vector3d>();
  if (!(direction.norm() > 0)) value->fail("a direction cannot be zero");
  return direction.normalized();
}

double read_nonzero(const ConfigNode& node, const std::string& key) {
  const double value = node.get<double>(key);
  if (value == 0) node.at(key).fail("cannot be 0");
  return value;
}

Pose read_start(const ConfigNode& node, Mover mover) {
  const auto start = node.find("start");
  if (!start) return {};
  const Pose pose = read_pose(*start, mover);
  start->refuse_unknown_keys();
  return pose;
}

Motion read_line(const ConfigNode& node, Mover mover) {
  std::optional<double> rolling;
  if (node.has("rolling_radius_m")) rolling = node.positive("rolling_radius_m");
  return line_motion(read_start(node, mover), node.get<Vector3d>("velocity_mps"), rolling);
}

Motion read_circle(const ConfigNode& node, Mover mover) {
  CircleOptions options;
  options.center_m = node.get<Vector3d>("center_m");
  options.normal = read_direction(node, "normal", options.normal);
  options.radius_m = node.positive("radius_m");
  options.start_rad = radians(node.get<double>("start_deg", 0));
  options.rate_radps = radians(node.get<double>("rate_degps"));
  options.sway_rad = radians(node.get<double>("sway_deg", 0));
  options.sway_period_s = node.positive("sway_period_s", options.sway_period_s);
  options.optical = mover == Mover::camera;
  const std::string facing = node.choice("facing", {"fixed", "tangent", "target", "rolling"}, "fixed");
  if (facing == "target") {
    options.facing = CircleOptions::Facing::target;
    options.target_m = node.get<Vector3d>("look_at_m");
    if (mover != Mover::camera) node.at("facing").fail("target is for cameras");
    return circle_motion(options);
  }
  options.orientation = read_orientation(node, mover, options.center_m);
  if (facing == "tangent") options.facing = CircleOptions::Facing::tangent;
  if (facing == "rolling") {
    options.facing = CircleOptions::Facing::rolling;
    options.rolling_radius_m = node.positive("rolling_radius_m");
  }
  return circle_motion(options);
}

Motion read_swing(const ConfigNode& node, Mover mover) {
  SwingOptions options;
  options.pivot_m = node.get<Vector3d>("pivot_m");
  options.axis = read_direction(node, "axis", options.axis);
  if (options.axis.z() != 0) node.at("axis").fail("a pendulum's axis is horizontal");
  options.length_m = node.positive("length_m");
  options.amplitude_rad = radians(node.get<double>("amplitude_deg"));
  options.period_s = node.positive("period_s");
  options.phase_rad = radians(node.get<double>("phase_deg", 0));
  options.orientation = read_orientation(node, mover, options.pivot_m - options.length_m * Vector3d::UnitZ());
  return swing_motion(options);
}

Motion read_screw(const ConfigNode& node, Mover mover) {
  ScrewOptions options;
  options.start = read_start(node, mover);
  options.axis = read_direction(node, "axis", options.axis);
  options.point_m = node.get<Vector3d>("point_m", options.start.translation);
  options.rate_radps = radians(read_nonzero(node, "rate_degps"));
  options.pitch_m = node.get<double>("pitch_m", 0);
  return screw_motion(options);
}

Motion read_tremor(const ConfigNode& node) {
  TremorOptions options;
  constexpr double kMost_m = 0.1, kMost_deg = 20;  // ours: a hand that shakes more holds nothing
  options.position_m = read_at_most(node, "position_m", options.position_m, kMost_m);
  options.rotation_rad = radians(read_at_most(node, "rotation_deg", 0.2, kMost_deg));
  options.seed = node.get<std::uint64_t>("seed", 0);
  return tremor_motion(options);
}

DriveLeg read_leg(const ConfigNode& item) {
  constexpr double kMostSteer_deg = 80;
  constexpr double kMost_s = 86'400, kMost_mps2 = 100;  // ours: a day; ten times what tyres hold
  DriveLeg leg{read_positive(item, "duration_s", 0, kMost_s),
               read_within(item, "acceleration_mps2", 0, kMost_mps2), 0};
  const double steer_deg = item.get<double>("steer_deg", 0);
  if (std::abs(steer_deg) > kMostSteer_deg)
    item.at("steer_deg").fail(fmt::format("expected at most {} to each side", kMostSteer_deg));
  leg.steer_rad = radians(steer_deg);
  item.refuse_unknown_keys();
  return leg;
}

Motion read_drive(const ConfigNode& node, Mover mover) {
  DriveOptions options;
  const auto start = node.get<std::vector<double>>("start_m");
  if (start.size() != 2) node.at("start_m").fail(fmt::format("expected 2 numbers, found {}", start.size()));
  options.start_m = {start[0], start[1]};
  options.heading_rad = radians(node.get<double>("heading_deg", 0));
  constexpr double kMost_mps = 300;  // ours: the fastest car
  options.speed_mps = read_between(node, "speed_mps", node.get<double>("speed_mps"), 0, kMost_mps);
  options.begins_s = node.get<double>("begins_s", 0);
  options.wheelbase_m = node.positive("wheelbase_m", options.wheelbase_m);
  options.steering_s = read_at_least_0(node, "steering_s", options.steering_s);
  options.ahead_m = node.get<double>("ahead_m", options.wheelbase_m / 2);
  options.height_m = node.get<double>("height_m", 0);
  options.optical = mover == Mover::camera;
  if (const auto legs = node.find("legs"))
    for (const ConfigNode& item : legs->items()) options.legs.push_back(read_leg(item));
  return drive_motion(options);
}

Motion read_toss(const ConfigNode& node, const MotionScope& scope) {
  if (scope.mover == Mover::camera)
    node.at("kind").fail("toss is for bodies: a camera has no shape that hits a floor");
  TossOptions options;
  options.start = read_start(node, scope.mover);
  constexpr double kMost_mps = 1000, kMost_degps = 36'000;  // ours: a bullet, and 100 turns a second
  options.velocity_mps = read_within(node, "velocity_mps", options.velocity_mps, kMost_mps);
  options.angular_velocity_radps =
      radians(1) * read_within(node, "angular_velocity_degps", options.angular_velocity_radps, kMost_degps);
  options.begins_s = node.get<double>("begins_s", options.begins_s);
  options.floor_m = node.get<double>("floor_m", options.floor_m);
  options.restitution = read_share(node, "restitution", options.restitution);
  options.friction = read_at_least_0(node, "friction", options.friction);
  options.gravity_mps2 = node.positive("gravity_mps2", options.gravity_mps2);
  node.refuse_unknown_keys();  // before what a wrong key leaves out is found wrong
  try {
    return toss_motion(options, contact_points(scope.meshes));
  } catch (const InputError& error) {
    node.fail(error.what());
  }
}

Motion read_composed(const ConfigNode& node, const MotionScope& scope) {
  std::vector<Motion> parts;
  for (const ConfigNode& item : node.at("parts").items()) parts.push_back(read_motion(item, scope));
  if (parts.empty()) node.at("parts").fail("expected at least one motion");
  return composed_motion(std::move(parts));
}

Motion read_kind(const ConfigNode& node, const MotionScope& scope) {
  const Mover mover = scope.mover;
  const std::string kind = node.choice("kind",
                                       {"static", "line", "circle", "swing", "screw", "spline", "recorded",
                                        "toss", "tremor", "drive", "compose"},
                                       "");
  if (kind == "static") return static_motion(read_pose(node, mover));
  if (kind == "line") return read_line(node, mover);
  if (kind == "circle") return read_circle(node, mover);
  if (kind == "swing") return read_swing(node, mover);
  if (kind == "screw") return read_screw(node, mover);
  if (kind == "spline") return read_spline(node, mover);
  if (kind == "recorded") return read_recorded(node, scope.files, scope.end_s);
  if (kind == "toss") return read_toss(node, scope);
  if (kind == "tremor") return read_tremor(node);
  if (kind == "drive") return read_drive(node, mover);
  if (kind == "compose") return read_composed(node, scope);
  node.fail("missing key 'kind'");
}

}  // namespace

Motion read_motion(const ConfigNode& node, const MotionScope& scope) {
  const Motion motion = read_kind(node, scope);
  node.refuse_unknown_keys();
  return motion;
}

}  // namespace uniquadric
