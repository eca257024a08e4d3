#pragma once

#include <Eigen/Core>
#include <memory>

#include "core/geometry/pose.h"

namespace uniquadric {

/// How a body moves at one instant.
struct Kinematics {
  Pose pose;  ///< world_from_body
  /// Of the body's origin, in the world frame.
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero(), acceleration_mps2 = Eigen::Vector3d::Zero();
  /// In the body frame.
  Eigen::Vector3d angular_velocity_radps = Eigen::Vector3d::Zero(),
                  angular_acceleration_radps2 = Eigen::Vector3d::Zero();
};

/// The motion of c in a, from that of b in a and that of c in b (in whose frames "world" and "body" then
/// are).
Kinematics operator*(const Kinematics& a_from_b, const Kinematics& b_from_c);

/// A smooth trajectory through SE(3): world_from_body as a function of time.
class Motion {
 public:
  class Curve;
  Motion();  ///< at rest at the world's origin
  explicit Motion(std::shared_ptr<const Curve> curve);

  /// Pose at `time_s` [s] from the sequence's start; defined for every time (clamped outside its way-points).
  Pose at(double time_s) const;
  /// Pose, velocity and acceleration from the same formula, differentiated analytically. At rest outside the
  /// way-points; where the acceleration jumps (a spline's ends) that of the moving side.
  Kinematics kinematics(double time_s) const;

 private:
  std::shared_ptr<const Curve> curve_;
};

}  // namespace uniquadric
