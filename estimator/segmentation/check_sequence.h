#pragma once

#include <cstdint>
#include <map>
#include <optional>

#include "core/geometry/pose.h"
#include "core/sequence/sequence.h"
#include "estimator/segmentation/segmentation.h"

namespace uniquadric {

/// Throws InputError when no frame of the sequence has what a state takes - depth, masks (or boxes to find
/// them in) and, where `poses` (by stamp in ns) are given, a camera pose - and says which is missing: stamps
/// that do not meet are a mistake in the input, not a result. A camera followed by a LiDAR (`by_lidar`) is a
/// result without depth or masks too, but depth images that are asked for (`wants_images`) must be there.
/// Of the scans see require_scans().
void check_sequence(const Sequence& sequence, const PromptedSegmenter& segmenter,
                    const std::optional<std::map<std::int64_t, Pose>>& poses, bool by_lidar = false,
                    bool wants_images = false);

}  // namespace uniquadric
