#include "evaluation/comparison/metric_change.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>
#include <tuple>

namespace uniquadric {
namespace {

// A mean that is built value by value.
struct Mean {
  double sum = 0;
  std::size_t n = 0;
  void add(double value) { sum += value, ++n; }
  double get() const { return sum / static_cast<double>(n); }
};

// A figure of each (sequence, seed): the mean over the objects there.
using Runs = std::map<std::string, std::map<std::uint64_t, Mean>>;

template <typename Figure>
Runs by_run(const MetricPairs& pairs, const Figure& figure) {
  Runs runs;
  for (const PairedScore* pair : pairs) runs[pair->key.run.sequence][pair->key.run.seed].add(figure(*pair));
  return runs;
}

// What each run counts in the mean over sequences of the means over seeds.
std::vector<double> weights_of(const Runs& runs) {
  std::vector<double> weights;
  for (const auto& [sequence, seeds] : runs)
    weights.insert(weights.end(), seeds.size(), 1 / static_cast<double>(seeds.size() * runs.size()));
  return weights;
}

// The summands of that mean.
std::vector<double> weighted(const Runs& runs) {
  std::vector<double> summands;
  for (const auto& [sequence, seeds] : runs)
    for (const auto& [seed, mean] : seeds)
      summands.push_back(mean.get() / static_cast<double>(seeds.size() * runs.size()));
  return summands;
}

double sum(const std::vector<double>& values) {
  double result = 0;
  for (const double value : values) result += value;
  return result;
}

double norm(const std::vector<double>& values) {
  double squares = 0;
  for (const double value : values) squares += value * value;
  return std::sqrt(squares);
}

// Greatest loss first.
std::vector<PlaceChange> measure_places(const MetricPairs& pairs, const ChangeRule& rule) {
  std::map<std::pair<std::string, std::string>, std::map<std::uint64_t, double>> losses;
  for (const PairedScore* pair : pairs)
    losses[{pair->key.run.sequence, pair->key.object}][pair->key.run.seed] = loss(rule, pair->a, pair->b);
  std::vector<PlaceChange> places;
  for (const auto& [place, by_seed] : losses) {
    PlaceChange& change = places.emplace_back();
    std::tie(change.sequence, change.object) = place;
    change.losses = by_seed;
    for (const auto& [seed, lost] : by_seed) change.loss += lost / static_cast<double>(by_seed.size());
  }
  std::stable_sort(places.begin(), places.end(),
                   [](const PlaceChange& x, const PlaceChange& y) { return x.loss > y.loss; });
  return places;
}

}  // namespace

std::string subjects_of_object(const std::string& object) {
  return object == "camera" || object == "all" ? object : "objects";
}

std::string stream_of(const MetricChange& change) {
  return fmt::format("compare/{}/{}/{}", change.variant, change.subjects, change.metric);
}

MetricChange measure_change(const MetricPairs& pairs, const ChangeRule& rule) {
  assert(!pairs.empty());
  const ScoreKey& key = pairs.front()->key;
  MetricChange change;
  change.variant = key.run.variant;
  change.metric = key.metric;
  change.subjects = subjects_of_object(key.object);
  change.rule = rule;
  const Runs runs = by_run(pairs, [&](const PairedScore& pair) { return loss(rule, pair.a, pair.b); });
  change.summands = weighted(runs);
  change.weights = weights_of(runs);
  change.sequences = runs.size();
  change.pairs = change.summands.size();
  change.loss = sum(change.summands);
  change.noise = norm(change.summands);
  const auto mean = [&](double PairedScore::*side) {
    // Of errors that all count as the least one there is, the mean is their own: 0 stays 0.
    const bool tiny = std::all_of(pairs.begin(), pairs.end(),
                                  [&](const PairedScore* p) { return counts_as_none(rule, p->*side); });
    if (tiny) return sum(weighted(by_run(pairs, [&](const PairedScore& p) { return p.*side; })));
    return from_scale(
        rule, sum(weighted(by_run(pairs, [&](const PairedScore& p) { return to_scale(rule, p.*side); }))));
  };
  change.a = mean(&PairedScore::a);
  change.b = mean(&PairedScore::b);
  change.test = sign_flip(change.summands, stream_of(change));
  change.places = measure_places(pairs, rule);
  return change;
}

}  // namespace uniquadric
