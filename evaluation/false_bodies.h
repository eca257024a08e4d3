#pragma once

#include <vector>

#include "core/sequence/tracks.h"

namespace uniquadric {

/// How many of the tracks with `unmatched_ids` the estimate stands by: those with a state that is active or
/// occluded. A track that is tentative throughout claims no object.
int count_false_bodies(const std::vector<ObjectTrack>& estimate, const std::vector<int>& unmatched_ids);

}  // namespace uniquadric
