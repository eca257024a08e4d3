#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "core/sequence/ply.h"
#include "core/sequence/tracks.h"
#include "estimator/base/stopwatch.h"
#include "estimator/perception/perception_files.h"
#include "estimator/variant.h"

namespace uniquadric {

/// What a back end makes of a perception. Objects come in order of their ids.
struct BackendResult {
  std::vector<ObjectTrack> causal;  ///< states as known at their frame
  /// States as known a fixed lag after their frame, and at the end; nothing: the back end never goes back.
  std::optional<std::vector<ObjectTrack>> fixed_lag, final;
  std::map<int, SurfaceFile> surfaces;  ///< points that were seen of them, in the frame of their last state
  int observations_without_state = 0;   ///< bodies in frames of which nothing could be said
  std::vector<StageTime> times;
};

/// The dual sliding window (Eq. 5) on every body of a perception, each by itself.
BackendResult estimate_windows(const Perception& perception, const Variant& variant, std::uint64_t seed);

}  // namespace uniquadric
