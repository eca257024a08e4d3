#include "evaluation/association/stamps.h"

#include <algorithm>
#include <cstdlib>
#include <tuple>
#include <utility>

#include "core/base/quantile.h"

namespace uniquadric {
namespace {

using Stamps = std::vector<std::int64_t>;

// ours: one frame that is missing makes two periods, and stamps of a camera tremble by less than half of one
constexpr double kLongestStep_periods = 1.5;

std::vector<IndexPair> nearest_pairs(const Stamps& reference, const Stamps& estimate, std::int64_t limit) {
  const bool estimate_is_longer = estimate.size() > reference.size();
  const Stamps& shorter = estimate_is_longer ? reference : estimate;
  const Stamps& longer = estimate_is_longer ? estimate : reference;
  std::vector<IndexPair> pairs;
  pairs.reserve(shorter.size());
  for (std::size_t i = 0, j = 0; i < shorter.size() && !longer.empty(); ++i) {
    const auto away = [&](std::size_t k) { return std::abs(longer[k] - shorter[i]); };
    while (j + 1 < longer.size() && away(j + 1) < away(j)) ++j;
    if (away(j) > limit) continue;
    pairs.push_back(estimate_is_longer ? IndexPair{i, j} : IndexPair{j, i});
  }
  return pairs;
}

std::vector<IndexPair> exclusive_pairs(const Stamps& reference, const Stamps& estimate, std::int64_t limit) {
  std::vector<std::tuple<std::int64_t, std::size_t, std::size_t>> candidates;
  std::size_t first = 0;
  for (std::size_t i = 0; i < reference.size(); ++i) {
    while (first < estimate.size() && estimate[first] < reference[i] - limit) ++first;
    for (std::size_t j = first; j < estimate.size() && estimate[j] <= reference[i] + limit; ++j)
      candidates.emplace_back(std::abs(estimate[j] - reference[i]), i, j);
  }
  std::sort(candidates.begin(), candidates.end());
  std::vector<bool> reference_taken(reference.size()), estimate_taken(estimate.size());
  std::vector<IndexPair> pairs;
  for (const auto& [difference, i, j] : candidates) {
    if (reference_taken[i] || estimate_taken[j]) continue;
    reference_taken[i] = estimate_taken[j] = true;
    pairs.push_back({i, j});
  }
  std::sort(pairs.begin(), pairs.end(),
            [](const auto& a, const auto& b) { return a.reference < b.reference; });
  return pairs;
}

}  // namespace

std::size_t nearest_index(const Stamps& stamps, std::int64_t stamp) {
  const auto after = std::lower_bound(stamps.begin(), stamps.end(), stamp);
  if (after == stamps.begin()) return 0;
  const std::size_t before = static_cast<std::size_t>(after - stamps.begin()) - 1;
  if (after == stamps.end()) return before;
  return stamp - stamps[before] <= *after - stamp ? before : before + 1;
}

std::int64_t median_period_ns(const Stamps& stamps) {
  Stamps periods;
  for (std::size_t k = 1; k < stamps.size(); ++k) periods.push_back(stamps[k] - stamps[k - 1]);
  return periods.empty() ? 0 : upper_median(std::move(periods));
}

std::vector<bool> are_next_frames(const Stamps& stamps) {
  const double longest_ns = kLongestStep_periods * static_cast<double>(median_period_ns(stamps));
  std::vector<bool> next(stamps.size());
  for (std::size_t k = 1; k < stamps.size(); ++k)
    next[k] = static_cast<double>(stamps[k] - stamps[k - 1]) <= longest_ns;
  return next;
}

std::vector<IndexPair> associate(const Stamps& reference_ns, const Stamps& estimate_ns,
                                 const StampOptions& options) {
  return options.rule == StampRule::nearest
             ? nearest_pairs(reference_ns, estimate_ns, options.max_difference_ns)
             : exclusive_pairs(reference_ns, estimate_ns, options.max_difference_ns);
}

}  // namespace uniquadric
