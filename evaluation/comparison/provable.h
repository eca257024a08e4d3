#pragma once

#include <vector>

#include "evaluation/comparison/score_comparison.h"

namespace uniquadric {

/// Whether the metric may fail the gate at all: computing time may only if asked.
bool may_fail(const MetricChange& change, const GateOptions& options);

/// Whether the pairs are enough for any claim: one sequence needs as many seeds as one place.
bool has_enough_seeds(const MetricChange& change, const GateOptions& options);

/// Whether some loss could be found worse: of the mean, or of one place.
bool is_judged(const MetricChange& change);

/// Whether the metric has lost more than its margin, proven or not.
bool shows_loss(const MetricChange& change);

/// Fills `judged_by_mean` and `judged_by_place`, which depend on the numbers of pairs and of metrics that
/// differ alone. Those judged by their mean are the ones that Holm corrects for: the others, whose p cannot
/// be small enough, are left out, as Tarone does.
void mark_judged(std::vector<MetricChange>& changes, const GateOptions& options);

/// Fills `provable` of metrics that are judged by their mean: the smallest loss T that would be worse when
/// every pair had lost the same more or less, the other metrics being as they are; at least the margin.
void measure_provable(std::vector<MetricChange>& changes, const GateOptions& options);

}  // namespace uniquadric
