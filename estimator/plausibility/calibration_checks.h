#pragma once

#include <string>
#include <vector>

#include "estimator/plausibility/frame_pairs.h"

namespace uniquadric {

/// Intrinsics that hardly any camera has: pixels that are not square, a principal point far from the middle
/// or where it would be with both coordinates swapped. And intrinsics that the motion of points with depth
/// contradicts.
std::vector<std::string> intrinsic_suspicions(const Sequence& sequence, const std::vector<FramePair>& pairs);

}  // namespace uniquadric
