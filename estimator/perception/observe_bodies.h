#pragma once

#include <cstdint>

#include "estimator/perception/frame_work.h"
#include "estimator/perception/perceive.h"

namespace uniquadric {

/// The body of a frame with this id, a new one where it has none.
BodyObservation& body_of(PerceivedFrame& frame, int id);

/// Outlines, depth points and contact plane of each body under the frame's masks, and the outlines of the
/// segmenter's results that arrived. `camera` is the lens as it is: images are not undistorted. `seed`: of
/// the random samples.
void observe_bodies(const Camera& camera, const PerceptionOptions& options, std::uint64_t seed,
                    FrameWork& work);

}  // namespace uniquadric
