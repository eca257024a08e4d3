#pragma once

#include <string>
#include <vector>

#include "estimator/plausibility/frame_pairs.h"

namespace uniquadric {

/// Depth images, or masks, that are the same in frames whose colour has moved.
std::vector<std::string> repeated_depth_suspicions(const Sequence& sequence,
                                                   const std::vector<FramePair>& pairs);
std::vector<std::string> repeated_mask_suspicions(const Sequence& sequence,
                                                  const std::vector<FramePair>& pairs);

}  // namespace uniquadric
