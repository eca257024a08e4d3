#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/sequence/tracks.h"

namespace uniquadric {

/// What looks like millimetres, a line each that names the file: positions and sizes that are more than
/// kUnitRatio times the reference's or less; where there is no reference, speeds beyond 150 m/s and sizes
/// beyond 50 m. `camera` is the reference's (the truth's, or the given one; empty: none).
std::vector<std::string> unit_faults(const std::filesystem::path& folder, const Tracks& estimate,
                                     const Trajectory& camera, const Tracks* truth);

/// Sizes about twice the truth's, or half of them, of the objects that overlap a true one, the median of all;
/// the estimate is in the truth's world.
std::optional<std::string> size_faults(const std::filesystem::path& folder, const Tracks& estimate,
                                       const Tracks& truth);

/// Tracks of the truth with the track of the estimate that overlaps each most.
std::vector<std::pair<const ObjectTrack*, const ObjectTrack*>> matched_tracks(const Tracks& truth,
                                                                              const Tracks& estimate);

}  // namespace uniquadric
