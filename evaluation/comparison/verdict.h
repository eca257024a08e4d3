#pragma once

#include <vector>

#include "evaluation/comparison/score_comparison.h"

namespace uniquadric {

/// Corrects the p of all metrics and places for their number and gives every metric its verdict and reason.
void decide(std::vector<MetricChange>& changes, const GateOptions& options);

/// Whether a place's loss is more than chance.
inline bool is_proven(const PlaceChange& place, const GateOptions& options) {
  return place.p && *place.p <= options.place_alpha;
}

}  // namespace uniquadric
