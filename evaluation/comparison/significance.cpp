#include "evaluation/comparison/significance.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numeric>

#include "core/base/random.h"

namespace uniquadric {
namespace {

constexpr std::size_t kByte = 8, kWord = 32;
// Sums that differ by rounding alone are the same: relative to the sum of the sizes.
constexpr double kRounding = 1e-12;

// The sums of eight differences at a time under all their 256 flips: a flip of all is then a few additions.
class FlippedSums {
 public:
  explicit FlippedSums(const std::vector<double>& differences) {
    for (std::size_t begin = 0; begin < differences.size(); begin += kByte) {
      auto& sums = parts_.emplace_back();
      const std::size_t end = std::min(begin + kByte, differences.size());
      for (std::size_t flips = 0; flips < sums.size(); ++flips)
        for (std::size_t i = begin; i < end; ++i)
          sums[flips] += flips >> (i - begin) & 1 ? -differences[i] : differences[i];
    }
  }
  double operator()(const std::uint32_t* words) const {
    double sum = 0;
    for (std::size_t i = 0; i < parts_.size(); ++i)
      sum += parts_[i][words[i * kByte / kWord] >> (i * kByte % kWord) & 0xff];
    return sum;
  }

 private:
  std::vector<std::array<double, 256>> parts_;
};

// Calls `visit(words)` for the flips that the test looks at: all of up to kMostExactPairs differences, else
// those that are drawn.
template <typename Visit>
void for_each_flip(std::size_t n, std::string_view stream, const Visit& visit) {
  if (n <= kMostExactPairs) {
    for (std::uint32_t flips = 0; flips < std::uint32_t{1} << n; ++flips) visit(&flips);
    return;
  }
  RandomStream random(0, stream);
  const std::size_t words_a_draw = (n + kWord - 1) / kWord;
  constexpr std::size_t kBlock = 1000;  // draws at a time
  static_assert(kSignFlipDraws % kBlock == 0);
  std::vector<std::uint32_t> words(words_a_draw * kBlock);
  for (std::size_t block = 0; block < kSignFlipDraws / kBlock; ++block) {
    random.fill(words);
    for (std::size_t i = 0; i < kBlock; ++i) visit(&words[i * words_a_draw]);
  }
}

double sum_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

}  // namespace

SignFlip sign_flip(const std::vector<double>& differences, std::string_view stream) {
  std::vector<double> differing;
  std::copy_if(differences.begin(), differences.end(), std::back_inserter(differing),
               [](double d) { return d != 0; });
  SignFlip result;
  result.differing = differing.size();
  if (differing.empty()) return result;
  const FlippedSums sums(differing);
  const double size = std::transform_reduce(differing.begin(), differing.end(), 0.0, std::plus<>(),
                                            [](double d) { return std::abs(d); });
  const double observed = sum_of(differing), rounding = kRounding * size;
  result.exact = differing.size() <= kMostExactPairs;
  std::size_t above = result.exact ? 0 : 1, below = above;  // what was observed is one more draw
  for_each_flip(differing.size(), stream, [&](const std::uint32_t* words) {
    const double sum = sums(words);
    above += sum >= observed - rounding;
    below += sum <= observed + rounding;
  });
  const double n = result.exact ? std::exp2(differing.size()) : kSignFlipDraws + 1;
  result.p_above = static_cast<double>(above) / n;
  result.p_below = static_cast<double>(below) / n;
  return result;
}

double least_p(std::size_t pairs) {
  return pairs <= kMostExactPairs ? std::exp2(-static_cast<double>(pairs)) : 1.0 / (kSignFlipDraws + 1);
}

// A flip turns the signs of a subset. It counts against a loss while the subset's sum of difference + s *
// weight is not above 0, so up to one s of its own: the ratio of the subset's sums.
std::optional<double> provable_shift(const std::vector<double>& differences,
                                     const std::vector<double>& weights, double p, std::string_view stream) {
  const FlippedSums difference_sums(differences), weight_sums(weights);
  const double difference = sum_of(differences), weight = sum_of(weights);
  const bool exact = differences.size() <= kMostExactPairs;
  const double flips = exact ? std::exp2(differences.size()) : kSignFlipDraws + 1;
  const double allowed = std::floor(p * flips * (1 + kRounding));
  std::vector<double> shifts;
  std::size_t always = exact ? 0 : 1;  // flips of no sign, which count for every s
  for_each_flip(differences.size(), stream, [&](const std::uint32_t* words) {
    const double turned = weight - weight_sums(words);
    if (turned > kRounding * weight)
      shifts.push_back((difference_sums(words) - difference) / turned);
    else
      ++always;
  });
  if (allowed < static_cast<double>(always)) return std::nullopt;
  const auto rank = static_cast<std::size_t>(allowed) - always;
  if (rank >= shifts.size()) return std::nullopt;  // p is 1
  std::nth_element(shifts.begin(), shifts.begin() + std::ptrdiff_t(rank), shifts.end(), std::greater<>());
  return shifts[rank];
}

std::vector<double> holm(const std::vector<double>& p) {
  std::vector<std::size_t> order(p.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return std::pair(p[a], a) < std::pair(p[b], b); });
  std::vector<double> corrected(p.size());
  double before = 0;
  for (std::size_t rank = 0; rank < order.size(); ++rank) {
    const double factor = static_cast<double>(p.size() - rank);
    before = corrected[order[rank]] = std::min(1.0, std::max(before, factor * p[order[rank]]));
  }
  return corrected;
}

double holm_level(std::vector<double> others, double alpha) {
  std::sort(others.begin(), others.end());
  const std::size_t tests = others.size() + 1;
  std::size_t rejected = 0;
  while (rejected < others.size() && others[rejected] <= alpha / static_cast<double>(tests - rejected))
    ++rejected;
  return alpha / static_cast<double>(tests - rejected);
}

double tarone_level(const std::vector<double>& least, double alpha) {
  for (std::size_t k = 1;; ++k) {
    const double level = alpha / static_cast<double>(k);
    const auto able = std::count_if(least.begin(), least.end(), [&](double p) { return p <= level; });
    if (static_cast<std::size_t>(able) <= k) return level;
  }
}

}  // namespace uniquadric
