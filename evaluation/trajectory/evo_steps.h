#pragma once

#include <vector>

#include "core/geometry/pose.h"
#include "evaluation/trajectory/delta_pairs.h"

namespace uniquadric {

/// Steps as evo chooses them, where that differs from delta_steps: in metres, one after the other, a step
/// ends with the first pose at or past delta, and the first step starts where the first delta is reached; in
/// degrees, one after the other, the turns between neighbours are summed up, and with all pairs every pose
/// within the tolerance ends a step. Throws InputError for seconds, which evo does not know, and as
/// delta_steps does.
std::vector<IndexStep> evo_steps(const std::vector<Pose>& poses, const DeltaOptions& options);

}  // namespace uniquadric
