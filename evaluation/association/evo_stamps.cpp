#include "evaluation/association/evo_stamps.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace uniquadric {
namespace {

struct IndexedStamp {
  double stamp_s = 0;
  std::size_t index = 0;
};

// In order of the stamps, of equal ones the first.
std::vector<IndexedStamp> sorted_stamps(const std::vector<double>& stamps_s) {
  std::vector<IndexedStamp> sorted;
  sorted.reserve(stamps_s.size());
  for (const double stamp_s : stamps_s) sorted.push_back({stamp_s, sorted.size()});
  std::ranges::stable_sort(sorted, {}, &IndexedStamp::stamp_s);
  const auto rest = std::ranges::unique(sorted, {}, &IndexedStamp::stamp_s);
  sorted.erase(rest.begin(), rest.end());
  return sorted;
}

// The first index of those that no other is nearer than: differences may be equal by rounding.
std::size_t first_nearest(const std::vector<IndexedStamp>& sorted, double stamp_s) {
  const auto away_s = [&](const IndexedStamp& other) { return std::abs(other.stamp_s - stamp_s); };
  const auto after = std::ranges::lower_bound(sorted, stamp_s, {}, &IndexedStamp::stamp_s);
  auto begin = after == sorted.begin() ? after : after - 1, end = after == sorted.end() ? after : after + 1;
  const double least_s = std::min(away_s(*begin), away_s(*(end - 1)));
  while (begin != sorted.begin() && away_s(*(begin - 1)) == least_s) --begin;
  while (end != sorted.end() && away_s(*end) == least_s) ++end;
  std::size_t first = std::numeric_limits<std::size_t>::max();
  for (; begin != end; ++begin)
    if (away_s(*begin) == least_s) first = std::min(first, begin->index);
  return first;
}

}  // namespace

std::vector<IndexPair> associate_as_evo(const std::vector<double>& reference_s,
                                        const std::vector<double>& estimate_s, double max_difference_s) {
  const bool estimate_is_longer = estimate_s.size() > reference_s.size();
  const std::vector<double>& shorter = estimate_is_longer ? reference_s : estimate_s;
  const std::vector<double>& longer = estimate_is_longer ? estimate_s : reference_s;
  if (longer.empty()) return {};
  const std::vector<IndexedStamp> sorted = sorted_stamps(longer);
  std::vector<IndexPair> pairs;
  pairs.reserve(shorter.size());
  for (std::size_t i = 0; i < shorter.size(); ++i) {
    const std::size_t j = first_nearest(sorted, shorter[i]);
    if (!(std::abs(longer[j] - shorter[i]) <= max_difference_s)) continue;
    pairs.push_back(estimate_is_longer ? IndexPair{i, j} : IndexPair{j, i});
  }
  return pairs;
}

}  // namespace uniquadric
