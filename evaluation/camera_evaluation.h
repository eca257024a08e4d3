#pragma once

#include <cstdint>
#include <optional>

#include "core/sequence/trajectory.h"
#include "evaluation/statistics/statistics.h"
#include "evaluation/trajectory/trajectory_error.h"

namespace uniquadric {

/// APE or RPE in both parts.
struct PoseStatistics {
  std::optional<Statistics> translation_m, rotation_rad;
};
PoseStatistics pose_statistics(const std::vector<PoseError>& errors);

struct CameraEvaluation {
  std::size_t truth_poses = 0, pairs = 0;
  double coverage = 0;  ///< share of the truth's poses that have an estimate
  PoseStatistics ape, rpe;
  std::optional<Drift> drift;
};

/// Pairs of nearest stamps (evo's rule); truth and estimate share the world frame. RPE runs
/// over consecutive poses of the truth; a step across a hole of the truth (are_next_frames), or with an end
/// that has no estimate, is left out. Fewer than 3 pairs leave all figures empty; the caller refuses them.
CameraEvaluation evaluate_camera(const Trajectory& truth, const Trajectory& estimate,
                                 std::int64_t max_difference_ns);

}  // namespace uniquadric
