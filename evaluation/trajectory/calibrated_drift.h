#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>

#include "core/geometry/pose.h"
#include "evaluation/trajectory/trajectory_error.h"

namespace uniquadric {

/// Drift as the Oxford Multimotion Dataset's own tool has it: an estimate may be of another frame of the same
/// rigid body. Poses count from the first one, e_k = P_k^-1 P_0 and g_k = Q_k^-1 Q_0; one calibration C
/// minimises sum |Log(C e_k C^-1 g_k^-1)|^2, and C e_k C^-1 g_k^-1 is the error of pair k.
struct CalibratedDrift {
  Pose reference_from_estimate;  ///< C: of the two body frames
  /// Whether the motion fixes all of C; a body that only turns about one axis, or does not turn, leaves a
  /// part of it open, and the errors do not depend on that part.
  bool determined = true;
  double max_translation_m = 0;
  /// of the reference's path up to the pair of max_translation_m; nothing where nothing has moved yet
  std::optional<double> max_translation_percent_of_path;
  double max_angle_rad = 0;                                      ///< of the error's rotation
  Eigen::Vector3d roll_pitch_yaw_rad = Eigen::Vector3d::Zero();  ///< of that rotation
  std::size_t translation_index = 0, angle_index = 0;            ///< pairs where the maxima are
};

/// Nothing for fewer than kMinPairs.
std::optional<CalibratedDrift> calibrated_drift(const PosePairs& poses);

}  // namespace uniquadric
