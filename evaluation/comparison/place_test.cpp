#include "evaluation/comparison/place_test.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <string>

#include "core/base/random.h"
#include "evaluation/statistics/statistics.h"

namespace uniquadric {
namespace {

constexpr double kRounding = 1e-12;  // relative: T that differ by rounding alone are the same

using Losses = std::map<std::uint64_t, double>;  // by seed

struct TestedPlace {
  PlaceChange* place;
  Losses losses;        // of a place that gained, what is left without that
  double usual_square;  // of the metric: median over its places of the mean squared loss
};

// A gain turned round would be a loss that nobody saw, and hide one elsewhere. What is left without the mean
// is smaller than the noise was by one seed's share.
Losses without_gain(const PlaceChange& place) {
  Losses losses = place.losses;
  if (place.loss >= 0) return losses;
  const double n = static_cast<double>(losses.size());
  for (auto& [seed, loss] : losses) loss = (loss - place.loss) * std::sqrt(n / (n - 1));
  return losses;
}

double mean_square(const Losses& losses) {
  double sum = 0;
  for (const auto& [seed, loss] : losses) sum += loss * loss;
  return sum / static_cast<double>(losses.size());
}

bool is_tested(const PlaceChange& place, std::size_t least_seeds) {
  return place.losses.size() >= std::max<std::size_t>(least_seeds, 2) &&
         std::any_of(place.losses.begin(), place.losses.end(), [](const auto& of) { return of.second != 0; });
}

std::map<std::string, std::vector<TestedPlace>> tested_by_sequence(std::vector<MetricChange>& changes,
                                                                   const GateOptions& options) {
  std::map<std::string, std::vector<TestedPlace>> tested;
  for (MetricChange& change : changes) {
    if (change.rule.is_time && !options.gate_time) continue;
    std::vector<TestedPlace> places;
    std::vector<double> squares;
    for (PlaceChange& place : change.places) {
      if (!is_tested(place, options.place_seeds)) continue;
      places.push_back({&place, without_gain(place), 0});
      squares.push_back(mean_square(places.back().losses));
    }
    const double usual_square = places.empty() ? 0 : statistics(squares)->median;
    for (TestedPlace& place : places) {
      place.usual_square = usual_square;
      tested[place.place->sequence].push_back(std::move(place));
    }
  }
  return tested;
}

// Signs of a sequence's seeds, one flip after the other; the first is what was observed.
std::vector<std::vector<double>> flips_of(const std::string& sequence, std::size_t seeds) {
  const bool exact = seeds <= kMostExactSeeds;
  RandomStream random(0, fmt::format("compare/places/{}", sequence));
  std::vector<std::vector<double>> flips(exact ? std::size_t{1} << seeds : kPlaceFlips,
                                         std::vector<double>(seeds, 1));
  for (std::size_t f = 1; f < flips.size(); ++f)
    for (std::size_t i = 0; i < seeds; ++i)
      if (exact ? (f >> i & 1) != 0 : random.uniform() < 0.5) flips[f][i] = -1;
  return flips;
}

// T of every place under a flip: the first are those that were observed.
class SequenceFlips {
 public:
  SequenceFlips(const std::string& sequence, const std::vector<TestedPlace>& places) : places_(places) {
    std::set<std::uint64_t> seeds;
    for (const TestedPlace& tested : places)
      for (const auto& [seed, loss] : tested.losses) seeds.insert(seed);
    const std::vector<std::uint64_t> order(seeds.begin(), seeds.end());
    for (const std::vector<double>& signs : flips_of(sequence, order.size())) {
      double greatest = -std::numeric_limits<double>::infinity();
      for (const TestedPlace& tested : places) {
        const double t = t_of(tested, order, signs);
        if (greatest_.empty()) observed_.push_back(t);
        greatest = std::max(greatest, t);
      }
      greatest_.push_back(greatest);
    }
    std::sort(greatest_.begin(), greatest_.end());
  }

  const std::vector<TestedPlace>& places() const { return places_; }
  double observed(std::size_t place) const { return observed_[place]; }
  // The share of flips under which some place here has at least this T.
  double share_at_least(double t) const {
    const double least = t - kRounding * std::abs(t);
    const auto first = std::lower_bound(greatest_.begin(), greatest_.end(), least);
    return static_cast<double>(greatest_.end() - first) / static_cast<double>(greatest_.size());
  }

 private:
  static double t_of(const TestedPlace& tested, const std::vector<std::uint64_t>& order,
                     const std::vector<double>& signs) {
    const Losses& losses = tested.losses;
    const double n = static_cast<double>(losses.size());
    double sum = 0, squares = 0;
    auto next = losses.begin();
    for (std::size_t i = 0; i < order.size() && next != losses.end(); ++i) {
      if (next->first != order[i]) continue;
      sum += signs[i] * next->second;
      squares += next->second * next->second;
      ++next;
    }
    const double rest = std::max(0.0, squares - sum * sum / n);  // n - 1 times the place's own variance
    const double variance =
        (kPooledDegreesOfFreedom * tested.usual_square + rest) / (kPooledDegreesOfFreedom + n - 1);
    return variance > 0 ? sum / std::sqrt(n * variance)
                        : 0;  // 0: gained the same in all seeds, as the others did
  }

  std::vector<TestedPlace> places_;
  std::vector<double> observed_, greatest_;
};

}  // namespace

void test_places(std::vector<MetricChange>& changes, const GateOptions& options) {
  std::vector<SequenceFlips> sequences;
  for (const auto& [sequence, places] : tested_by_sequence(changes, options))
    sequences.emplace_back(sequence, places);
  for (const SequenceFlips& sequence : sequences)
    for (std::size_t i = 0; i < sequence.places().size(); ++i) {
      double none = 1;  // seeds of one sequence are not those of another: their flips are independent
      for (const SequenceFlips& other : sequences) none *= 1 - other.share_at_least(sequence.observed(i));
      sequence.places()[i].place->p = 1 - none;
    }
}

}  // namespace uniquadric
