#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/sequence/tracks.h"
#include "evaluation/align/symmetry.h"
#include "evaluation/iou/monte_carlo.h"
#include "evaluation/trajectory/trajectory_error.h"

namespace uniquadric {

/// One object at one truth frame. Empty where there is no estimate, or no such figure of it.
struct ObjectFrame {
  std::int64_t frame = 0, stamp_ns = 0;
  Eigen::Vector3d true_semi_axes_m;
  std::optional<Ellipsoid> estimate;  ///< axes renamed, body frame turned within the true shape's symmetry
  std::optional<PoseError> ape;       ///< of `estimate`
  std::optional<double> ape_rotation_naive_rad;  ///< of the estimate as it came
  std::optional<double> rotation_symmetric_rad;  ///< by the class of the true axes; empty for spheres
  std::optional<PoseError> rpe, motion;          ///< from the truth frame before, when both are estimated
  std::optional<double> iou3d, d_shape_m;
  std::optional<MonteCarloIou> iou3d_monte_carlo;
  std::optional<double> iou2d, iou2d_ellipse;  ///< empty where one of the two has no elliptic outline
};

struct ObjectEvaluation {
  int id = 0;
  std::string name;
  std::optional<int> matched_id;
  std::vector<ObjectFrame> frames;  ///< all frames of the truth
  std::size_t matched_frames = 0;
  std::optional<double>
      coverage;  ///< share of the truth's frames with an estimate; empty without truth frames
  std::optional<double> longest_gap_s;  ///< longest time without, a frame standing until the next one
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
  std::int64_t max_difference_ns = 10'000'000;
};

/// Compares a truth object with the track it was matched to. `matched_states[k]` is the index of the track's
/// state at the truth's state k. `track` null: never found. Fills everything except `id_switches`.
ObjectEvaluation evaluate_object(const ObjectTrack& truth, const std::string& shape, const ObjectTrack* track,
                                 const std::vector<std::optional<std::size_t>>& matched_states,
                                 const ObjectContext& context);

}  // namespace uniquadric
