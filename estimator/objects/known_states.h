#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "estimator/objects/body_estimator.h"

namespace uniquadric {

/// A body's state as its estimator gave it at its frame, and the camera's poses that are known of that frame.
struct RawState {
  BodyState state;
  FrameInfo frame;
};

/// The states of a body as they are known `lag_ns` after their frames (0: at them), given all raw states of
/// its life in the frames' order: each with the shape of then, at the newest pose of a trajectory smoothed
/// up to then (smooth_trajectory). The body's frame is the object's afterwards. Where `lag_ns` > 0, poses
/// stand in the world of the camera's lagged poses, and states are missing of a life that had led nowhere by
/// then.
std::vector<BodyState> states_known_after(std::int64_t lag_ns, const std::vector<RawState>& raw,
                                          const TrajectorySmootherOptions& options);

/// Looks at a state that was guessed again, about an expected world_from_body.
using LookAgain = std::function<void(BodyState& state, const Pose& expected)>;

/// The states as they are known at the end: the last shape of each life, its whole trajectory smoothed, in
/// the world of the camera's final poses. A body is begun anew where its first sights led nowhere: of such
/// lives there are no states. The body's frame is the object's afterwards.
std::vector<BodyState> final_states(const std::vector<RawState>& raw,
                                    const TrajectorySmootherOptions& options, const LookAgain& look_again);

}  // namespace uniquadric
