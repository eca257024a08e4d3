#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "core/geometry/pose.h"

namespace uniquadric {

/// What is done about the frame of a body, which is the estimate's own choice where bodies are unknown (the
/// paper's T_align): nothing, where frames are defined; the first poses made to coincide; least squares.
enum class BodyFrame { none, first, fit };
const char* to_string(BodyFrame kind);
std::optional<BodyFrame> parse_body_frame(std::string_view text);

/// The D by which world_from_body * D of an estimate comes to the reference's: one for the whole track, from
/// the right. `fit` is the least-squares turn and, apart from it, the least-squares shift. Lists of equal
/// length, in pairs; without pairs the identity.
Pose body_frame_offset(BodyFrame kind, const std::vector<Pose>& reference, const std::vector<Pose>& estimate);

/// Where the track's frame usually lies in the reference's, reference_from_estimate: the geometric median of
/// the pairs' (Weiszfeld's iteration), a turn of 1 rad weighing as `lever_m` metres. Frames in which the
/// track is far off, as long as they are the fewer, hardly move it. Needs a pair.
Pose usual_body_offset(const std::vector<Pose>& reference, const std::vector<Pose>& estimate, double lever_m);

}  // namespace uniquadric
