#pragma once

#include <string>
#include <vector>

#include "core/sequence/sequence.h"
#include "estimator/plausibility/plausibility_options.h"

namespace uniquadric {

/// What in a sequence is well-formed but hardly right: poses, depth, calibration, clocks, IMU, scans or masks
/// that contradict each other. One sentence each, which names the file and the likely cause. A test compares
/// the sequence as it is with what a usual mistake would have made of it, over a few pairs of frames. Files
/// that cannot be read are left to who reads them all.
std::vector<std::string> suspicions(const Sequence& sequence, const PlausibilityOptions& options);

}  // namespace uniquadric
