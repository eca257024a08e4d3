#pragma once

#include <string>
#include <vector>

#include "estimator/plausibility/frame_pairs.h"

namespace uniquadric {

/// Whether points with depth move more rigidly once their depth is read in another way: as the length of the
/// ray in place of z along the optical axis.
std::vector<std::string> depth_form_suspicions(const Sequence& sequence, const std::vector<FramePair>& pairs);

}  // namespace uniquadric
