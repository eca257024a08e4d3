#include "evaluation/comparison/verdict.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "evaluation/comparison/place_test.h"
#include "evaluation/comparison/provable.h"

namespace uniquadric {
namespace {

// A metric in which nothing differs has nothing to test, one that is not judged cannot prove anything: they
// do not count among those that Holm corrects for.
bool is_tested(const MetricChange& change) {
  return change.test.differing > 0 && change.judged_by_mean;
}

void correct_means(std::vector<MetricChange>& changes) {
  std::vector<MetricChange*> tested;
  std::vector<double> above, below;
  for (MetricChange& change : changes) {
    if (!is_tested(change)) continue;
    tested.push_back(&change);
    above.push_back(change.test.p_above);
    below.push_back(change.test.p_below);
  }
  above = holm(above);
  below = holm(below);
  for (std::size_t i = 0; i < tested.size(); ++i) {
    tested[i]->p_worse = above[i];
    tested[i]->p_better = below[i];
  }
}

bool has_lost(const PlaceChange& place, double margin, const GateOptions& options) {
  return is_proven(place, options) && place.loss > margin;
}

// Whether every pair lost, and yet there are too few of them for the test to say it.
bool is_too_few(const MetricChange& change, const GateOptions& options) {
  const double least_p = std::exp2(-static_cast<double>(change.test.differing));
  return least_p > options.suspect_p && change.test.p_above <= least_p;
}

bool any_place_lost(const MetricChange& change, double margin, const GateOptions& options) {
  return std::any_of(change.places.begin(), change.places.end(),
                     [&](const PlaceChange& place) { return has_lost(place, margin, options); });
}

std::pair<Verdict, VerdictReason> judge_time(const MetricChange& change, const GateOptions& options) {
  const bool grew = change.loss > change.rule.margin &&
                    (change.test.p_above <= options.suspect_p || is_too_few(change, options));
  return {grew ? Verdict::suspect : Verdict::no_proven_change,
          grew ? VerdictReason::time_only : VerdictReason::none};
}

std::pair<Verdict, VerdictReason> judge(const MetricChange& change, const GateOptions& options) {
  if (!may_fail(change, options)) return judge_time(change, options);
  if (!is_judged(change)) return {Verdict::not_judged, VerdictReason::few_pairs};
  const double margin = change.rule.margin;
  const bool large = shows_loss(change);
  const bool proven = change.p_worse && *change.p_worse <= options.alpha;
  if (large && proven) return {Verdict::worse, VerdictReason::none};
  if (any_place_lost(change, change.rule.place_margin, options))
    return {Verdict::worse, VerdictReason::one_place};
  if (large && is_too_few(change, options)) return {Verdict::suspect, VerdictReason::few_differ};
  if (change.test.differing > 0 && (proven || change.test.p_above <= options.suspect_p))
    return {Verdict::suspect, large ? VerdictReason::not_proven : VerdictReason::below_margin};
  if (any_place_lost(change, margin, options)) return {Verdict::suspect, VerdictReason::one_place};
  if (-change.loss > margin && change.p_better && *change.p_better <= options.alpha)
    return {Verdict::better, VerdictReason::none};
  return {Verdict::no_proven_change, VerdictReason::none};
}

}  // namespace

void decide(std::vector<MetricChange>& changes, const GateOptions& options) {
  mark_judged(changes, options);
  correct_means(changes);
  measure_provable(changes, options);
  test_places(changes, options);
  for (MetricChange& change : changes)
    for (PlaceChange& place : change.places) place.worse = has_lost(place, change.rule.place_margin, options);
  for (MetricChange& change : changes) std::tie(change.verdict, change.reason) = judge(change, options);
}

const char* to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::worse:
      return "worse";
    case Verdict::suspect:
      return "suspect";
    case Verdict::not_judged:
      return "not judged";
    case Verdict::better:
      return "better";
    case Verdict::no_proven_change:
      break;
  }
  return "no proven change";
}

const char* to_string(VerdictReason reason) {
  switch (reason) {
    case VerdictReason::one_place:
      return "of one object";
    case VerdictReason::below_margin:
      return "below the margin";
    case VerdictReason::not_proven:
      return "not proven";
    case VerdictReason::few_pairs:
      return "too few pairs";
    case VerdictReason::few_differ:
      return "few pairs differ";
    case VerdictReason::time_only:
      return "time fails nothing";
    case VerdictReason::none:
      break;
  }
  return "";
}

const char* to_string(GateAnswer answer) {
  switch (answer) {
    case GateAnswer::worse:
      return "worse";
    case GateAnswer::undecided:
      return "undecided";
    case GateAnswer::incomplete:
      return "incomplete";
    case GateAnswer::pass:
      break;
  }
  return "pass";
}

}  // namespace uniquadric
