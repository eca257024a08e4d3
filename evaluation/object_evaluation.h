#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/sequence/calibration.h"
#include "core/sequence/tracks.h"
#include "evaluation/align/body_frame.h"
#include "evaluation/align/shape_symmetry.h"
#include "evaluation/feature_depth.h"
#include "evaluation/iou/monte_carlo.h"
#include "evaluation/iou/solid_iou.h"
#include "evaluation/metrics/surface_error.h"
#include "evaluation/object_frame.h"
#include "evaluation/object_presence.h"
#include "evaluation/trajectory/trajectory_error.h"

namespace uniquadric {

/// The estimated bodies of a track against the true one.
struct SolidScore {
  std::string
      truth;  ///< how the true body's inside is known: box, ellipsoid, closed, closed_unoriented, open
  std::string estimate;  ///< the estimate's: states, or of a mesh closed, closed_unoriented, open
  MeanIou iou;           ///< mean over the matched frames
};

struct ObjectEvaluation {
  int id = 0;
  std::string name;
  std::optional<int> matched_id;
  std::vector<ObjectFrame> frames;  ///< all frames of the truth
  std::size_t matched_frames = 0;
  ObjectPresence presence;
  int id_switches = 0;
  ShapeSymmetry symmetry;
  int relabel_flips =
      0;  ///< matched frames that by themselves would name the axes otherwise than their stretch
  std::optional<Drift> drift;
  std::optional<Pose> truth_from_body;  ///< where the track's own frame usually lies in the true one
  std::optional<SolidScore> solid;
  std::optional<double> surface_tolerance_m;  ///< of `surface_f1`
  std::optional<SurfaceError> surface;
  std::optional<FeatureDepthError> feature_depth;
};

/// The state of the track that an object was matched to, at one of the truth's states.
struct MatchedState {
  std::size_t index = 0;
  double iou3d = 0;  ///< exact, of the two ellipsoids as they came: matching has it already
};

/// What all objects' evaluation shares.
struct ObjectContext {
  Trajectory truth_camera, estimate_camera;
  std::optional<Camera> calibration;     ///< without it there is no 2D IoU
  const BallSamples* samples = nullptr;  ///< not owned
  VisibilityTable visibility;            ///< empty: all frames count as visible
  std::int64_t max_difference_ns = 10'000'000;
  BodyFrame body_frame = BodyFrame::none;  ///< of pose errors; overlaps do not depend on frames
};

/// Overlap of the boxes about a true body and its estimate `named`, whose axes bear the truth's names. The
/// box about a body of revolution is settled but for a turn about its axis, a ball's altogether: it is turned
/// to the estimated one, as NOCS does (Wang et al., CVPR 2019).
double symmetric_box_iou(const Ellipsoid& truth, const Ellipsoid& named, const ShapeSymmetry& symmetry);

/// Compares a truth object with the track it was matched to; of `description` shape and symmetry count.
/// `matched_states[k]` is the track's state at the truth's state k. `track` null: never found.
/// Fills everything except `id_switches`, `surface`, `feature_depth` and what object_solid.h fills.
ObjectEvaluation evaluate_object(const ObjectTrack& truth, const ObjectDescription& description,
                                 const ObjectTrack* track,
                                 const std::vector<std::optional<MatchedState>>& matched_states,
                                 const ObjectContext& context);

}  // namespace uniquadric
