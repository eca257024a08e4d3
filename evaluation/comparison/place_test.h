#pragma once

#include <vector>

#include "evaluation/comparison/score_comparison.h"

namespace uniquadric {

constexpr std::size_t kMostExactSeeds = 12;    // ours: 4096 flips of a sequence, all of them
constexpr std::size_t kPlaceFlips = 4096;      // of more seeds, drawn; what was observed is one
constexpr double kPooledDegreesOfFreedom = 4;  // ours: a metric's usual noise weighs as five seeds more

/// Fills `p` of every place that is to be tested (at least `place_seeds` seeds, some of which differ; of
/// times only if they may fail): the chance that any place of all of `changes` has so great a T when nothing
/// had changed, so it is corrected for their number already. T is the mean loss over its standard error, the
/// variance being between the place's own and what is usual for the metric (the median over its places). If
/// nothing had changed, what a run loses in all its figures at once would be as likely a gain: the signs of a
/// run are flipped together, all ways there are for up to kMostExactSeeds seeds of a sequence, and the
/// greatest T of each flip is what the observed ones are held against; places that gained count without their
/// gain. No shape of the noise is assumed, nor that figures of a run have nothing in common.
void test_places(std::vector<MetricChange>& changes, const GateOptions& options);

}  // namespace uniquadric
