#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "core/sequence/ply.h"
#include "core/sequence/tracks.h"
#include "estimator/perception/perception_files.h"
#include "estimator/stopwatch.h"
#include "estimator/variant.h"

namespace uniquadric {

/// What a back end makes of a perception.
struct BackendResult {
  std::vector<ObjectTrack> objects;     ///< in order of their ids
  std::map<int, SurfaceFile> surfaces;  ///< points that were seen of them, in the frame of their last state
  int observations_without_state = 0;   ///< bodies in frames of which nothing could be said
  std::vector<StageTime> times;
};

/// The dual sliding window (Eq. 5) on every body of a perception, each by itself.
BackendResult estimate_windows(const Perception& perception, const Variant& variant, std::uint64_t seed);

}  // namespace uniquadric
