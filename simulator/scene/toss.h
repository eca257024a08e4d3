#pragma once

#include <vector>

#include "simulator/scene/motion.h"

namespace uniquadric {

struct TossOptions {
  Pose start;
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero(),
                  angular_velocity_radps = Eigen::Vector3d::Zero();  ///< in the world
  double begins_s = 0;                                               ///< before it the body is held
  double floor_m = 0;                                                ///< height of the plane that it falls on
  double restitution = 0.4, friction = 0.4;                          ///< from 0 to 1; 0 or more
  double gravity_mps2 = 9.81;
};

/// A rigid body that is let go, flies, hits a horizontal plane with its `contacts` (points in its own frame)
/// and comes to rest, simulated at small even steps for 30 s at most. Its density is even and its inertia
/// that of its tight box. An impact first stops the contacts that sink in, friction included; the whole
/// impulse is then made larger by the restitution, so that no impact adds energy. Pose and velocity are
/// continuous after the release, an impact takes one step; the acceleration is that of the interpolation.
/// Throws InputError when the body starts below the plane.
Motion toss_motion(const TossOptions& options, const std::vector<Eigen::Vector3d>& contacts);

}  // namespace uniquadric
