#pragma once

#include <vector>

#include "core/geometry/pose.h"

namespace uniquadric {

/// The same numbers throughout.
bool same_pose(const Pose& a, const Pose& b);

/// Length of the path from the first pose to each [m].
std::vector<double> path_lengths_m(const std::vector<Pose>& poses);

/// Both parts of the difference of two poses or motions.
struct PoseError {
  double translation_m = 0, rotation_rad = 0;
};

/// Absolute error: |p_est - p_ref| and the angle of R_est^T R_ref.
PoseError absolute_error(const Pose& reference, const Pose& estimate);
double absolute_distance_m(const Pose& reference, const Pose& estimate);
double absolute_angle_rad(const Pose& reference, const Pose& estimate);

/// Relative error of the motion from time i to time j: E = (Q_i^-1 Q_j)^-1 (P_i^-1 P_j), Q the reference, P
/// the estimate; its translation's norm and its angle.
PoseError relative_error(const Pose& reference_i, const Pose& reference_j, const Pose& estimate_i,
                         const Pose& estimate_j);

/// Error of an object's motion in the world, whatever body frame the estimate uses: L^-1 H_ref^-1 H_est L
/// with H = X_j X_i^-1 and L the true object pose at i.
PoseError object_motion_error(const Pose& reference_i, const Pose& reference_j, const Pose& estimate_i,
                              const Pose& estimate_j);

/// Frobenius norm of E - I for the relative error's E (evo's full_transformation), without unit.
double full_relative_error(const Pose& reference_i, const Pose& reference_j, const Pose& estimate_i,
                           const Pose& estimate_j);
/// Frobenius norm of reference^-1 estimate - I.
double full_absolute_error(const Pose& reference, const Pose& estimate);

}  // namespace uniquadric
