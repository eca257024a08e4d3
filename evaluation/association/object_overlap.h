#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/sequence/tracks.h"
#include "evaluation/association/stamps.h"

namespace uniquadric {

/// Truth objects (rows) against estimated tracks (columns) over all frames of the truth: the stamps of its
/// objects' states, and those of its camera's poses that are near none of them.
struct ObjectOverlaps {
  std::vector<std::int64_t> stamps_ns;                            ///< of the frames, increasing
  std::vector<std::vector<std::optional<std::size_t>>> truth;     ///< [object][frame] -> index of state
  std::vector<std::vector<std::optional<std::size_t>>> estimate;  ///< [track][frame] -> index of state
  /// [object][track][frame]: 3D IoU, 0 where one of the two has no state
  std::vector<std::vector<std::vector<double>>> iou3d;
};

/// States are associated by their stamps, one to one; estimated states that say `lost` are no states, and
/// those at no frame are left out.
ObjectOverlaps overlap_objects(const Tracks& truth, const Tracks& estimate, std::int64_t max_difference_ns);

/// The estimated track of each truth object: the assignment with the greatest overlap summed over time,
/// nothing where no track ever overlaps. Ids play no part.
std::vector<std::optional<std::size_t>> match_objects(const ObjectOverlaps& overlaps);

}  // namespace uniquadric
