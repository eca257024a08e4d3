#pragma once

#include <string>
#include <vector>

#include "estimator/plausibility/frame_pairs.h"

namespace uniquadric {

/// What is doubtful of camera_given.tum against the motion that the frame pairs show: poses that explain the
/// images much better once they are inverted, reordered, in other axes, another unit or at another time.
std::vector<std::string> given_pose_suspicions(const Sequence& sequence, const std::vector<FramePair>& pairs);

}  // namespace uniquadric
