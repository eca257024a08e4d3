#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/sequence/tracks.h"

namespace uniquadric {

// Whether an estimate looks as if it was in another unit than the truth, millimetres for one: its lengths are
// more than kUnitRatio times as long or short. A hint in words, nothing where they are alike or one is 0.
inline constexpr double kUnitRatio = 100;  // ours: no estimate of the same scene is off by as much

/// By the root mean square distance of positions from their mean.
std::optional<std::string> spread_fault(const std::vector<Pose>& reference,
                                        const std::vector<Pose>& estimate);

/// Median semi-axis of all states [m]; 0 of none.
double median_semi_axis_m(const std::vector<ObjectTrack>& tracks);

/// By median_semi_axis_m().
std::optional<std::string> size_fault(const std::vector<ObjectTrack>& truth,
                                      const std::vector<ObjectTrack>& estimate);

}  // namespace uniquadric
