#pragma once

#include <optional>
#include <vector>

#include "evaluation/association/object_overlap.h"

namespace uniquadric {

/// Scores of multi-object tracking with the 3D IoU as similarity, defined as in TrackEval (J. Luiten, 2020):
/// its HOTA assigns once, steered by how well pairs fit over all time, where the paper prints an assignment
/// for each threshold.
struct TrackingScores {
  double hota = 0;  ///< mean over the thresholds 0.05, 0.10, ..., 0.95 (Luiten et al., HOTA, IJCV 2021)
  double mota = 0;  ///< at kClearThreshold (Bernardin and Stiefelhagen, 2008); may be negative
  double idf1 = 0;  ///< at kClearThreshold (Ristani et al., 2016)
};
inline constexpr double kClearThreshold = 0.5;

/// Nothing when there is no truth object at any time.
std::optional<TrackingScores> tracking_scores(const ObjectOverlaps& overlaps);

/// How often each truth object's track changes, frame by frame assignment of all that overlap at least
/// `threshold`, tracks being kept where they can.
std::vector<int> identity_switches(const ObjectOverlaps& overlaps, double threshold);

}  // namespace uniquadric
