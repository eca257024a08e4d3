#pragma once

#include <array>

#include "simulator/scene/curve.h"

namespace uniquadric {

/// A step from one control pose to the next; position and rotation are split (SO(3) x R^3).
struct Step {
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();  ///< rotation vector in the frame turned so far [rad]
};

/// A cumulative cubic: from `origin` on by three steps, each by its share at this instant.
inline Kinematics cumulative(const Pose& origin, const std::array<Step, 3>& steps,
                             const std::array<Jet, 3>& shares) {
  Kinematics result = at_rest({origin.rotation, Eigen::Vector3d::Zero()});
  for (int k = 0; k < 3; ++k) result = result * turning(steps[k].turn, shares[k]);
  result.pose.rotation.normalize();
  result.pose.translation = origin.translation;
  for (int k = 0; k < 3; ++k) {
    const Kinematics shift = shifting(steps[k].shift_m, shares[k]);
    result.pose.translation += shift.pose.translation;
    result.velocity_mps += shift.velocity_mps;
    result.acceleration_mps2 += shift.acceleration_mps2;
  }
  return result;
}

}  // namespace uniquadric
