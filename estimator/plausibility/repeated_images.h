#pragma once

#include <string>
#include <vector>

#include "estimator/plausibility/frame_pairs.h"

namespace uniquadric {

/// Depth images or masks that are the same in frames whose colour has moved, and colour that is the same in
/// all frames where others move.
std::vector<std::string> repeat_suspicions(const Sequence& sequence, const std::vector<FramePair>& pairs);

}  // namespace uniquadric
