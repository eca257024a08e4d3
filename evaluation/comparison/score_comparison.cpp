#include "evaluation/comparison/score_comparison.h"

#include <algorithm>
#include <map>
#include <tuple>

#include "evaluation/comparison/metric_change.h"
#include "evaluation/comparison/provable.h"
#include "evaluation/comparison/verdict.h"

namespace uniquadric {
namespace {

// Every metric on its own, uncorrected.
std::vector<MetricChange> measure_changes(const Pairing& pairing, const ScoreTable& table) {
  std::map<std::tuple<std::string, std::string, std::string>, MetricPairs> groups;
  for (const PairedScore& pair : pairing.pairs)
    groups[{pair.key.run.variant, subjects_of_object(pair.key.object), pair.key.metric}].push_back(&pair);
  std::vector<MetricChange> changes;
  for (const auto& [group, pairs] : groups) {
    const std::string& metric = std::get<2>(group);
    changes.push_back(measure_change(pairs, change_rule(metric, table.lower_is_better.at(metric))));
  }
  return changes;
}

// A loss in units of its margin: what makes metrics of different units comparable.
double severity(const MetricChange& change) {
  double most = change.loss / change.rule.margin;
  for (const PlaceChange& place : change.places)
    if (place.worse) most = std::max(most, place.loss / change.rule.place_margin);
  return most;
}

bool is_before(const MetricChange& x, const MetricChange& y) {
  const auto order = [](const MetricChange& c) {
    return std::tuple(c.verdict, c.rule.is_time, -severity(c), c.variant, c.subjects, c.metric);
  };
  return order(x) < order(y);
}

// Metrics that cannot prove anything decide where there are no others.
bool is_undecided(const std::vector<MetricChange>& metrics) {
  return std::none_of(metrics.begin(), metrics.end(), is_judged) &&
         std::any_of(metrics.begin(), metrics.end(), [](const MetricChange& change) {
           return change.verdict == Verdict::not_judged && shows_loss(change);
         });
}

GateAnswer answer(const ScoreComparison& comparison) {
  const Pairing& pairing = comparison.pairing;
  if (!pairing.new_failures.empty() || count_verdicts(comparison, Verdict::worse) > 0)
    return GateAnswer::worse;
  if (pairing.pairs.empty() || !pairing.missing_in_a.empty() || !pairing.missing_in_b.empty())
    return GateAnswer::incomplete;
  return is_undecided(comparison.metrics) ? GateAnswer::undecided : GateAnswer::pass;
}

}  // namespace

ScoreComparison compare_scores(const ScoreTable& a, const ScoreTable& b, const GateOptions& options) {
  ScoreComparison comparison;
  comparison.a = a.file.string();
  comparison.b = b.file.string();
  comparison.options = options;
  comparison.pairing = pair_scores(a, b);
  comparison.metrics = measure_changes(comparison.pairing, a);
  decide(comparison.metrics, options);
  std::sort(comparison.metrics.begin(), comparison.metrics.end(), is_before);
  comparison.answer = answer(comparison);
  return comparison;
}

std::size_t count_verdicts(const ScoreComparison& comparison, Verdict verdict) {
  return static_cast<std::size_t>(
      std::count_if(comparison.metrics.begin(), comparison.metrics.end(),
                    [&](const MetricChange& change) { return change.verdict == verdict; }));
}

}  // namespace uniquadric
