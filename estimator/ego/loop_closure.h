#pragma once

#include <optional>
#include <vector>

#include "estimator/ego/ego_map.h"
#include "estimator/images/rigid_motion.h"

namespace uniquadric {

/// All numbers are ours.
struct LoopOptions {
  static constexpr int min_gap_keyframes = 12;  // since a point was seen last, for it to speak of a return
  int min_points = 12;                          // that must agree on the camera's pose
  static constexpr double min_disagreement_px =
      1;  // of these points with the pose so far; below, there is nothing to mend
  static constexpr double loop_sigma = 0.1;  // of a loop's edge, of that of the path's edges
  RigidMotionOptions motion;
};

/// A place seen again: where the newest keyframe is by the old points, and the keyframe that knows them best.
struct Loop {
  int old_keyframe = 0;
  Pose camera_from_world;  ///< of the newest keyframe
};

/// Whether the features of the newest frame see points that no keyframe has seen for long, and these agree on
/// another pose than `camera_from_world`.
std::optional<Loop> find_loop(const EgoMap& map, const Camera& camera, const std::vector<Feature>& features,
                              const Pose& camera_from_world, const LoopOptions& options,
                              RandomStream& random);

/// Bends the path of the keyframes so that the newest comes to the loop's pose (pose graph over neighbours
/// and the loop, Ceres), and moves each point along with the keyframe that saw it last.
void close_loop(EgoMap& map, const Loop& loop, const LoopOptions& options);

}  // namespace uniquadric
