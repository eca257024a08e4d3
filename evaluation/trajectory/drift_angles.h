#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>

#include "evaluation/trajectory/trajectory_error.h"

namespace uniquadric {

/// Roll, pitch, yaw [rad] of R = Rz(yaw) Ry(pitch) Rx(roll), pitch in [-pi/2, pi/2].
Eigen::Vector3d roll_pitch_yaw(const Eigen::Matrix3d& R);

/// The signed extremes of one angle and the pairs where they are.
struct AngleExtremes {
  double min_rad = 0, max_rad = 0;
  std::size_t min_index = 0, max_index = 0;
};

/// Extremes of the drift's angles over a sequence: of Q_k^-1 P_k after the first poses have been made to
/// coincide (a positive yaw: the estimate has turned too far), unwrapped from pair to pair.
struct DriftAngles {
  AngleExtremes roll, pitch, yaw;
};
/// Nothing without pairs.
std::optional<DriftAngles> drift_angles(const PosePairs& poses);

}  // namespace uniquadric
