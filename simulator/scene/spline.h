#pragma once

#include <vector>

#include "simulator/scene/motion.h"

namespace uniquadric {

/// A pose that a body passes at a time.
struct Waypoint {
  double time_s = 0;
  Pose world_from_body;
};

/// Largest turn between neighbouring way-points [rad]: beyond it the shorter arc is a guess.
inline constexpr double kMaxWaypointTurn_rad = 2.6;

/// The cumulative cubic B-spline on SO(3) x R^3 that passes through the way-points exactly (Kim, Kim and
/// Shin, "A general construction scheme for unit quaternion curves", SIGGRAPH 1995; Sommer et al., "Efficient
/// derivative computation for cumulative B-splines on Lie groups", CVPR 2020, whose advice to split rotation
/// and translation we follow: way-points in line stay in line however the body turns). Knots stand at the
/// way-points' times; at the first and the last the body is at rest, and it stays there outside them, so
/// velocity is continuous everywhere and acceleration between the ends. Throws InputError when there are
/// fewer than two way-points, times do not increase, or neighbours turn by more than kMaxWaypointTurn_rad.
Motion spline_motion(const std::vector<Waypoint>& waypoints);

/// The uniform cumulative cubic B-spline whose control poses are recorded ones, resampled to their median
/// step: twice differentiable, and smoother than the record by the kernel (1, 4, 1) / 6. Before and after the
/// record the body rests at its ends. Throws InputError for fewer than two poses or times that do not
/// increase.
Motion recorded_motion(std::vector<Waypoint> record);

}  // namespace uniquadric
