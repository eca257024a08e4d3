#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "evaluation/association/object_overlap.h"

namespace uniquadric {

/// Takes truth objects out of frames in which they cannot be seen, so that they are no misses there.
/// `hidden[object][frame]`, `matches` as of match_objects. With the object goes, in that frame, the state of
/// the track that is matched to it and of the one that overlaps it: a prediction through an occlusion is no
/// false track. States that belong to a visible object stay. So it is with all states of the tracks that are
/// `left_out`[track], in frames that hide an object.
void drop_hidden(const std::vector<std::vector<bool>>& hidden,
                 const std::vector<std::optional<std::size_t>>& matches, const std::vector<bool>& left_out,
                 ObjectOverlaps& overlaps);

}  // namespace uniquadric
