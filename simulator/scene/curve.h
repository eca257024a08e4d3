#pragma once

#include "simulator/scene/jet.h"
#include "simulator/scene/motion.h"

namespace uniquadric {

/// What a motion evaluates: one analytic formula of time, put together from turns about fixed axes and
/// shifts, so that velocity and acceleration come out of the same formula.
class Motion::Curve {
 public:
  virtual ~Curve() = default;
  virtual Kinematics kinematics(double time_s) const = 0;
  virtual Pose at(double time_s) const { return kinematics(time_s).pose; }
};

/// At rest.
inline Kinematics at_rest(const Pose& pose) {
  Kinematics result;
  result.pose = pose;
  return result;
}

/// A turn by `angle` times `axis` (any length) about the origin.
inline Kinematics turning(const Eigen::Vector3d& axis, const Jet& angle) {
  Kinematics result;
  result.pose.rotation = exp_so3(angle.value * axis);
  result.angular_velocity_radps = angle.rate * axis;  // the axis is the same in both frames
  result.angular_acceleration_radps2 = angle.acceleration * axis;
  return result;
}

/// A shift by `way` times `direction` (any length).
inline Kinematics shifting(const Eigen::Vector3d& direction, const Jet& way) {
  Kinematics result;
  result.pose.translation = way.value * direction;
  result.velocity_mps = way.rate * direction;
  result.acceleration_mps2 = way.acceleration * direction;
  return result;
}

}  // namespace uniquadric
