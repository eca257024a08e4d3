#include "evaluation/comparison/provable.h"

#include <algorithm>
#include <cmath>

#include "evaluation/comparison/metric_change.h"

namespace uniquadric {
namespace {

bool can_lose_a_place(const MetricChange& change, const GateOptions& options) {
  return std::any_of(change.places.begin(), change.places.end(), [&](const PlaceChange& place) {
    const std::size_t seeds = place.losses.size();
    return seeds >= options.place_seeds && least_p(seeds) <= options.place_alpha;
  });
}

bool may_be_proven(const MetricChange& change, const GateOptions& options) {
  return may_fail(change, options) && has_enough_seeds(change, options);
}

// The p that the metric's mean has to reach beside the other metrics.
double level_beside(const std::vector<MetricChange>& changes, const MetricChange& change, double alpha) {
  std::vector<double> others;
  for (const MetricChange& other : changes)
    if (&other != &change && other.judged_by_mean && other.test.differing > 0)
      others.push_back(other.test.p_above);
  return holm_level(others, alpha);
}

}  // namespace

bool may_fail(const MetricChange& change, const GateOptions& options) {
  return !change.rule.is_time || options.gate_time;
}

bool has_enough_seeds(const MetricChange& change, const GateOptions& options) {
  return change.sequences > 1 || change.pairs >= options.place_seeds;
}

bool is_judged(const MetricChange& change) {
  return change.judged_by_mean || change.judged_by_place;
}

bool shows_loss(const MetricChange& change) {
  return change.loss > change.rule.margin;
}

void mark_judged(std::vector<MetricChange>& changes, const GateOptions& options) {
  std::vector<double> least;  // of what is tested
  for (const MetricChange& change : changes)
    if (may_be_proven(change, options) && change.test.differing > 0) least.push_back(least_p(change.pairs));
  const double level = tarone_level(least, options.alpha);
  for (MetricChange& change : changes) {
    change.judged_by_mean = may_be_proven(change, options) && least_p(change.pairs) <= level;
    change.judged_by_place = may_fail(change, options) && can_lose_a_place(change, options);
  }
}

void measure_provable(std::vector<MetricChange>& changes, const GateOptions& options) {
  for (MetricChange& change : changes) {
    if (!change.judged_by_mean) continue;
    const double level = level_beside(changes, change, options.alpha);
    const auto shift = provable_shift(change.summands, change.weights, level, stream_of(change));
    if (shift) change.provable = std::max(change.loss + *shift, change.rule.margin);
  }
}

}  // namespace uniquadric
