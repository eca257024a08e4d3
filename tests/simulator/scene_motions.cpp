#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "core/base/config.h"
#include "core/base/error.h"
#include "simulator/scene/motion_reader.h"
#include "simulator/scene/named_motions.h"
#include "simulator/scene/spline.h"
#include "tests/simulator/motion_differences.h"

namespace uniquadric {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;
constexpr double kRounding = 1e-12;   // m, rad: a dozen operations on numbers of order one
constexpr double kStep_s = 1e-4;      // of central differences
constexpr double kDifference = 1e-6;  // relative to speeds of order one: step^2 times third derivatives
const Vector3d kX = Vector3d::UnitX(), kY = Vector3d::UnitY(), kZ = Vector3d::UnitZ();

double apart_rad(const Quaterniond& a, const Quaterniond& b) {
  return log_so3(a.conjugate() * b).norm();
}

Vector3d velocity(const Motion& motion, double t, double h = kStep_s) {
  return (motion.at(t + h).translation - motion.at(t - h).translation) / (2 * h);
}
Vector3d angular_velocity(const Motion& motion, double t, double h = kStep_s) {  // in the world
  return log_so3(motion.at(t + h).rotation * motion.at(t - h).rotation.conjugate()) / (2 * h);
}

std::vector<Waypoint> uneven_waypoints() {
  return {{-1, {exp_so3({0.1, 0.2, 0.3}), {0, 0, 1}}},      {0.5, {exp_so3({0.9, -0.2, 0.6}), {1, 0.5, 1.2}}},
          {1.1, {exp_so3({1.2, 0.6, -0.3}), {1.5, -1, 2}}}, {3, {exp_so3({-0.3, 1.2, 0.4}), {0.2, 0.1, 0.5}}},
          {3.4, {exp_so3({-0.6, 0.9, 0.9}), {0, 0, 0}}},    {6, {exp_so3({0.2, 2.2, 0.8}), {-2, 1, 1}}}};
}

TEST(SplineMotion, PassesThroughWaypoints) {
  const auto waypoints = uneven_waypoints();
  const Motion motion = spline_motion(waypoints);
  for (const Waypoint& w : waypoints) {
    const Pose pose = motion.at(w.time_s);
    EXPECT_LT((pose.translation - w.world_from_body.translation).norm(), kRounding);
    EXPECT_LT(apart_rad(pose.rotation, w.world_from_body.rotation), kRounding);
    EXPECT_NEAR(pose.rotation.norm(), 1, kRounding);
  }
}

// With two way-points at rest the curve is the Bezier smooth step 3u^2 - 2u^3 along the line and about the
// fixed axis.
// Turns that are rounding, as of angles that came through sines, are none.
TEST(SplineMotion, PassesThroughWaypointsThatTurnByRoundingAlone) {
  std::vector<Waypoint> waypoints;
  for (int k = 0; k < 5; ++k)
    waypoints.push_back({double(k), {exp_so3({1e-17 * k * k, 0.4, 3e-17 * (k % 2)}), {1.0 * k, 0, 0}}});
  const Motion motion = spline_motion(waypoints);
  for (const Waypoint& w : waypoints)
    EXPECT_LT(apart_rad(motion.at(w.time_s).rotation, w.world_from_body.rotation), kRounding);
}

TEST(SplineMotion, OfTwoWaypointsIsTheSmoothStep) {
  const Vector3d turn(0.3, -1.1, 0.9), way(2, -1, 0.5);
  const Motion motion = spline_motion({{1, {}}, {3, {exp_so3(turn), way}}});
  for (const double u : {0.1, 0.25, 0.5, 0.8}) {
    const double s = u * u * (3 - 2 * u);
    const Pose pose = motion.at(1 + 2 * u);
    EXPECT_LT((pose.translation - s * way).norm(), kRounding);
    EXPECT_LT(apart_rad(pose.rotation, exp_so3(s * turn)), kRounding);
  }
}

TEST(SplineMotion, IsAtRestAtAndBeyondItsEnds) {
  const Motion motion = spline_motion(uneven_waypoints());
  for (const double t : {-1.0, 6.0}) {
    constexpr double kRestStep_s =
        1e-5;  // the rest of a one-sided difference is acceleration times step: below 1e-3
    EXPECT_LT(velocity(motion, t, kRestStep_s).norm(), 1e-3);
    EXPECT_LT(angular_velocity(motion, t, kRestStep_s).norm(), 1e-3);
  }
  EXPECT_EQ(motion.at(-100).translation, motion.at(-1).translation);
  EXPECT_EQ(motion.at(100).rotation.coeffs(), motion.at(6).rotation.coeffs());
}

// A jump of the second derivative across a knot would show as a difference that does not shrink with the
// step.
TEST(SplineMotion, HasContinuousAccelerationAcrossKnots) {
  const auto waypoints = uneven_waypoints();
  const Motion motion = spline_motion(waypoints);
  const double h = 1e-4;
  int knots = 0;
  for (std::size_t k = 1; k + 1 < waypoints.size(); ++k, ++knots) {
    const double t = waypoints[k].time_s;
    const Vector3d before = (velocity(motion, t - h) - velocity(motion, t - 3 * h)) / (2 * h);
    const Vector3d after = (velocity(motion, t + 3 * h) - velocity(motion, t + h)) / (2 * h);
    EXPECT_LT((after - before).norm(), 0.1);  // jerk of order 100 m/s^3 times 4 h, and rounding 1e-16 / h^2
    const Vector3d turning_before =
        (angular_velocity(motion, t - h) - angular_velocity(motion, t - 3 * h)) / (2 * h);
    const Vector3d turning_after =
        (angular_velocity(motion, t + 3 * h) - angular_velocity(motion, t + h)) / (2 * h);
    EXPECT_LT((turning_after - turning_before).norm(), 0.1);
  }
  EXPECT_EQ(knots, 4);
}

TEST(SplineMotion, MovesWithTheWorldFrame) {
  const Pose other_from_world{exp_so3({0.4, 2.0, -1.0}), {3, -2, 7}};
  auto waypoints = uneven_waypoints();
  const Motion motion = spline_motion(waypoints);
  for (Waypoint& w : waypoints) w.world_from_body = other_from_world * w.world_from_body;
  const Motion moved = spline_motion(waypoints);
  for (double t = -1; t < 6; t += 0.31) {
    const Pose expected = other_from_world * motion.at(t);
    EXPECT_LT((moved.at(t).translation - expected.translation).norm(), 1e-11);
    EXPECT_LT(apart_rad(moved.at(t).rotation, expected.rotation),
              1e-11);  // as well as the iteration solves it
  }
}

TEST(SplineMotion, RefusesBadWaypoints) {
  EXPECT_THROW(spline_motion({{0, {}}}), InputError);
  EXPECT_THROW(spline_motion({{0, {}}, {0, {}}}), InputError);
  EXPECT_THROW(spline_motion({{0, {}}, {1, {exp_so3({3, 0, 0}), Vector3d::Zero()}}}), InputError);
  std::vector<Waypoint> many;  // whose equations would fill the memory
  for (int k = 0; k < 200'000; ++k) many.push_back({double(k), {}});
  EXPECT_THROW(spline_motion(many), InputError);
}

Motion read(const std::string& yaml) {
  std::vector<std::filesystem::path> files;
  return read_motion(ConfigNode::parse(yaml, "motion.yaml"), {Mover::body, files});
}

TEST(SplineMotion, RestsWhereItHolds) {
  const std::string begin = "{time_s: 0, position_m: [0, 0, 0]}",
                    middle = "{time_s: 2, position_m: [1, 0, 0]", end = "{time_s: 5, position_m: [1, 2, 0]}";
  const auto of = [](const std::string& waypoints) {
    return read("kind: spline\nwaypoints: [" + waypoints + "]");
  };
  const Motion motion = of(begin + ", " + middle + ", hold_s: 1}, " + end);
  for (const double t : {2.0, 2.4, 3.0}) {
    EXPECT_EQ(motion.at(t).translation, kX) << t;
    EXPECT_EQ(motion.kinematics(t).velocity_mps, Vector3d::Zero()) << t;
  }
  EXPECT_LT((motion.at(1).translation - 0.5 * kX).norm(), kRounding);  // each half from rest to rest
  EXPECT_LT((motion.at(4).translation - (kX + kY)).norm(), kRounding);
  EXPECT_LT((motion.at(9).translation - (kX + 2 * kY)).norm(), kRounding);
  // at its ends a hold is the rest that is there anyhow
  const Motion early = of("{time_s: 0, position_m: [0, 0, 0], hold_s: 2}, " + end);
  EXPECT_EQ(early.at(1.9).translation, Vector3d::Zero());
  EXPECT_LT((early.at(3.5).translation - 0.5 * (kX + 2 * kY)).norm(), kRounding);
  EXPECT_EQ(of(begin + ", " + middle + ", hold_s: 1}").at(7).translation, kX);
  EXPECT_THROW(of(begin + ", " + middle + ", hold_s: 4}, " + end), InputError)
      << "it ends after the next one";
  EXPECT_THROW(of(begin + ", " + middle + ", hold_s: -1}, " + end), InputError);
}

TEST(LookAt, PutsTargetOnTheOpticalAxisAndUpUpwards) {
  const Vector3d eye(1, 2, 3), target(-2, 0.5, 1);
  const Pose world_from_camera = look_at(eye, target);
  const Vector3d seen = world_from_camera.inverse() * target;
  EXPECT_LT((seen - Vector3d(0, 0, (target - eye).norm())).norm(), kRounding);
  const Vector3d up_in_camera = world_from_camera.rotation.conjugate() * kZ;
  EXPECT_NEAR(up_in_camera.x(), 0, kRounding);
  EXPECT_LT(up_in_camera.y(), 0);  // the image's y points down
  EXPECT_THROW(look_at(eye, eye), InputError);
  EXPECT_THROW(look_at(eye, eye + kZ), InputError);
}

TEST(CircleMotion, FollowsItsLawAndFacesTheTangent) {
  CircleOptions options{.center_m = {1, 2, 3},
                        .radius_m = 0.8,
                        .start_rad = 0.3,
                        .rate_radps = -0.7,
                        .sway_rad = 0.4,
                        .sway_period_s = 3,
                        .facing = CircleOptions::Facing::tangent};
  for (const Vector3d& normal : {kZ, Vector3d(Vector3d(1, -2, 0.5).normalized())}) {
    options.normal = normal;
    const Motion motion = circle_motion(options);
    for (const double t : {0.0, 1.3, 2.9}) {
      const Pose pose = motion.at(t);
      EXPECT_NEAR((pose.translation - options.center_m).norm(), 0.8, kRounding);
      EXPECT_NEAR((pose.translation - options.center_m).dot(normal), 0, kRounding);
      const double rate = -0.7 + 0.4 * 2 * kPi / 3 * std::cos(2 * kPi * t / 3);
      EXPECT_NEAR(velocity(motion, t).norm(), 0.8 * std::abs(rate), kDifference);
      EXPECT_NEAR((pose.rotation * kX).dot(velocity(motion, t)), -0.8 * rate, kDifference);
      EXPECT_LT((pose.rotation * kZ - normal).norm(), kRounding);
    }
  }
}

// No slip: the ball's point on the floor does not move; and no spin about the floor's normal.
TEST(RollingMotion, TouchesTheFloorWithoutSlipOrSpin) {
  const double radius = 0.15;
  const Quaterniond start = exp_so3({0.3, 0.4, -0.5});
  CircleOptions options{.radius_m = 0.6,
                        .start_rad = 1,
                        .rate_radps = 0.9,
                        .sway_rad = 0.5,
                        .sway_period_s = 4,
                        .facing = CircleOptions::Facing::rolling,
                        .orientation = start,
                        .rolling_radius_m = radius};
  const Motion circle = circle_motion(options), line = line_motion({start, kZ}, {0.5, -0.8, 0}, radius);
  for (const Motion& motion : {circle, line})
    for (const double t : {0.0, 0.7, 2.2}) {
      const Vector3d omega = angular_velocity(motion, t);
      const Vector3d contact_velocity = velocity(motion, t) + omega.cross(-radius * kZ);
      EXPECT_LT(contact_velocity.norm(), kDifference);
      EXPECT_NEAR(omega.z(), 0, kDifference);
    }
  EXPECT_LT(apart_rad(circle.at(0).rotation, start), kRounding);
}

TEST(SwingMotion, HangsFromItsPivot) {
  const SwingOptions options{
      .pivot_m = {1, 1, 3}, .axis = kX, .length_m = 1.5, .amplitude_rad = 0.6, .period_s = 2.4};
  const Motion motion = swing_motion(options);
  EXPECT_LT((motion.at(0).translation - Vector3d(1, 1, 1.5)).norm(), kRounding);
  const Pose extreme = motion.at(0.6);  // a quarter period
  EXPECT_LT((extreme.translation - Vector3d(1, 1 + 1.5 * std::sin(0.6), 3 - 1.5 * std::cos(0.6))).norm(),
            kRounding);
  EXPECT_LT((extreme.rotation * Vector3d(0, 0, 1.5) + extreme.translation - options.pivot_m).norm(),
            kRounding);
  EXPECT_LT((motion.at(2.4 + 0.3).translation - motion.at(0.3).translation).norm(), kRounding);
}

TEST(ScrewMotion, AdvancesByItsPitchEachTurn) {
  const ScrewOptions options{.start = {exp_so3({0.2, 0, 0.1}), {2, 0, 1}},
                             .point_m = {1, 0, 0},
                             .axis = kZ,
                             .rate_radps = kPi,
                             .pitch_m = 0.3};
  const Motion motion = screw_motion(options);
  EXPECT_LT((motion.at(2).translation - Vector3d(2, 0, 1.3)).norm(), kRounding);  // one turn
  EXPECT_LT(apart_rad(motion.at(2).rotation, options.start.rotation), kRounding);
  EXPECT_LT((motion.at(1).translation - Vector3d(0, 0, 1.15)).norm(),
            kRounding);  // half a turn: the other side
}

TEST(ComposedMotion, IsTheProductOfItsParts) {
  const Motion outer = swing_motion({.length_m = 1, .amplitude_rad = 0.4}),
               inner = line_motion({}, {0.1, 0.2, 0.3});
  const Motion both = composed_motion({outer, inner});
  for (const double t : {0.0, 0.9}) {
    const Pose expected = outer.at(t) * inner.at(t);
    EXPECT_LT((both.at(t).translation - expected.translation).norm(), kRounding);
    EXPECT_LT(apart_rad(both.at(t).rotation, expected.rotation), kRounding);
  }
}

struct NamedMotion {
  std::string name;
  Motion motion;
};

std::vector<NamedMotion> every_motion() {
  using Facing = CircleOptions::Facing;
  const Vector3d tilted = Vector3d(1, -2, 0.5).normalized();
  const Quaterniond turned = exp_so3({0.3, 0.4, -0.5});
  std::vector<NamedMotion> list;
  const auto circle = [&](const std::string& name, Facing facing, const Vector3d& normal, double rate,
                          bool optical) {
    list.push_back({name, circle_motion({.center_m = {1, 2, 3},
                                         .normal = normal,
                                         .radius_m = 0.8,
                                         .start_rad = 0.3,
                                         .rate_radps = rate,
                                         .sway_rad = 0.4,
                                         .sway_period_s = 3,
                                         .facing = facing,
                                         .orientation = turned,
                                         .optical = optical,
                                         .target_m = {-0.5, 1, 0.4},
                                         .rolling_radius_m = 0.15})});
  };
  list.push_back({"static", static_motion({turned, {1, 2, 3}})});
  list.push_back({"line", line_motion({turned, {1, 2, 3}}, {0.5, -0.8, 0.2})});
  list.push_back({"rolling_line", line_motion({turned, {1, 2, 3}}, {0.5, -0.8, 0}, 0.2)});
  circle("circle_fixed", Facing::fixed, tilted, 0.7, false);
  circle("circle_tangent", Facing::tangent, tilted, 0.7, false);
  circle("circle_tangent_backwards", Facing::tangent, kZ, -0.7, false);
  circle("circle_tangent_camera", Facing::tangent, tilted, -0.7, true);
  circle("circle_target", Facing::target, tilted, 0.7, true);
  circle("circle_rolling", Facing::rolling, kZ, -0.7, false);
  list.push_back({"swing", swing_motion({.pivot_m = {1, 1, 3},
                                         .axis = Vector3d(1, 1, 0).normalized(),
                                         .length_m = 1.5,
                                         .amplitude_rad = 0.6,
                                         .period_s = 2.4,
                                         .phase_rad = 0.7,
                                         .orientation = turned})});
  list.push_back({"screw", screw_motion({.start = {turned, {2, 0, 1}},
                                         .point_m = {1, 0, 0},
                                         .axis = tilted,
                                         .rate_radps = 1.2,
                                         .pitch_m = 0.3})});
  list.push_back({"spline", spline_motion(uneven_waypoints())});
  list.push_back({"compose", composed_motion({list.back().motion, list[8].motion, list[9].motion})});
  return list;
}

TEST(Kinematics, EveryMotionMatchesDifferencesOfItsPoses) {
  // Truncation is h^4 / 30 of the fifth and h^4 / 90 of the sixth derivative (1e5 and 1e6 in these units: the
  // ball rolls at 9 rad/s, and the composition swings it about); rounding is 1e-16 / h and 1e-16 / h^2.
  constexpr double kWide_s = 1e-3, kRate = 1e-8, kAcceleration = 1e-7;
  int compared = 0;
  for (const auto& [name, motion] : every_motion())
    for (const double t : {-0.7, 0.0, 0.23, 0.81, 1.9, 3.21, 5.6}) {
      SCOPED_TRACE(name + " at " + std::to_string(t) + " s");
      scene_test::expect_derivatives(motion, t, kWide_s, kRate, kAcceleration);
      ++compared;
    }
  EXPECT_EQ(compared, 13 * 7);
}

TEST(Kinematics, SplineIsAtRestBeyondItsEnds) {
  const Motion motion = spline_motion(uneven_waypoints());
  for (const double t : {-1.5, 6.5}) {
    const Kinematics found = motion.kinematics(t);
    EXPECT_EQ(found.velocity_mps, Vector3d::Zero());
    EXPECT_EQ(found.acceleration_mps2, Vector3d::Zero());
    EXPECT_EQ(found.angular_velocity_radps, Vector3d::Zero());
    EXPECT_EQ(found.angular_acceleration_radps2, Vector3d::Zero());
  }
}

}  // namespace
}  // namespace uniquadric
