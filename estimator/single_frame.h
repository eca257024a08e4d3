#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/sequence/tracks.h"
#include "estimator/variant.h"

namespace uniquadric {

/// What one frame by itself says of its objects.
struct FrameEstimate {
  bool has_depth = false, has_masks = false, has_pose = false;
  int objects_without_state = 0;                          ///< seen in the masks, but with too few points
  std::map<int, ObjectState> states;                      ///< by id
  std::vector<std::pair<const char*, double>> timing_ms;  ///< by stage
  cv::Mat masks;                                          ///< CV_16UC1; empty without masks
};

/// Masks, points and Alg. 1 on one frame; `world_from_camera` absent: no state. The variance of the semi-axes
/// is Alg. 1's uncertainty squared; pose variances are not estimated. Axes are named as the world's.
FrameEstimate estimate_frame(const Sequence& sequence, const SequenceFrame& frame, const Segmenter& segmenter,
                             const Variant& variant, const std::optional<Pose>& world_from_camera,
                             std::uint64_t seed);

/// Renames the axes of a track's states, each to be nearest to the one before.
void follow_axes(ObjectTrack& track);

}  // namespace uniquadric
