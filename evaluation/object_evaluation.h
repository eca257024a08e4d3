#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/sequence/tracks.h"
#include "evaluation/align/symmetry.h"
#include "evaluation/iou/monte_carlo.h"
#include "evaluation/object_frame.h"
#include "evaluation/object_presence.h"
#include "evaluation/trajectory/trajectory_error.h"

namespace uniquadric {

struct ObjectEvaluation {
  int id = 0;
  std::string name;
  std::optional<int> matched_id;
  std::vector<ObjectFrame> frames;  ///< all frames of the truth
  std::size_t matched_frames = 0;
  ObjectPresence presence;
  int id_switches = 0;
  BodySymmetry symmetry = BodySymmetry::box;
  int relabel_flips = 0;  ///< matched frames that by themselves would name the axes otherwise than the track
  std::optional<Drift> drift;
};

/// Symmetry that a kind of mesh (objects.yaml's `shape`) and its semi-axes leave: bodies known to be round
/// are balls where the axes are equal and bodies of revolution where two are; everything else is box-like.
BodySymmetry body_symmetry(const std::string& shape, const Eigen::Vector3d& semi_axes_m);

/// What all objects' evaluation shares.
struct ObjectContext {
  Trajectory truth_camera, estimate_camera;
  std::optional<Camera> calibration;     ///< without it there is no 2D IoU
  const BallSamples* samples = nullptr;  ///< not owned
  VisibilityTable visibility;            ///< empty: all frames count as visible
  std::int64_t max_difference_ns = 10'000'000;
};

/// Compares a truth object with the track it was matched to. `matched_states[k]` is the index of the track's
/// state at the truth's state k. `track` null: never found. Fills everything except `id_switches`.
ObjectEvaluation evaluate_object(const ObjectTrack& truth, const std::string& shape, const ObjectTrack* track,
                                 const std::vector<std::optional<std::size_t>>& matched_states,
                                 const ObjectContext& context);

}  // namespace uniquadric
