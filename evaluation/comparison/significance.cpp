#include "evaluation/comparison/significance.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdint>
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

struct Counts {
  std::size_t above = 0, below = 0;
};

void count(double sum, double observed, double rounding, Counts& counts) {
  counts.above += sum >= observed - rounding;
  counts.below += sum <= observed + rounding;
}

Counts count_all(const FlippedSums& sums, std::size_t n, double observed, double rounding) {
  Counts counts;
  for (std::uint32_t flips = 0; flips < std::uint32_t{1} << n; ++flips)
    count(sums(&flips), observed, rounding, counts);
  return counts;
}

Counts count_drawn(const FlippedSums& sums, std::size_t n, double observed, double rounding,
                   std::string_view stream) {
  RandomStream random(0, stream);
  const std::size_t words_a_draw = (n + kWord - 1) / kWord;
  constexpr std::size_t kBlock = 1000;  // draws at a time
  static_assert(kSignFlipDraws % kBlock == 0);
  std::vector<std::uint32_t> words(words_a_draw * kBlock);
  Counts counts{1, 1};  // what was observed
  for (std::size_t block = 0; block < kSignFlipDraws / kBlock; ++block) {
    random.fill(words);
    for (std::size_t i = 0; i < kBlock; ++i)
      count(sums(&words[i * words_a_draw]), observed, rounding, counts);
  }
  return counts;
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
  const double observed = std::accumulate(differing.begin(), differing.end(), 0.0);
  result.exact = differing.size() <= kMostExactPairs;
  const Counts counts = result.exact
                            ? count_all(sums, differing.size(), observed, kRounding * size)
                            : count_drawn(sums, differing.size(), observed, kRounding * size, stream);
  const double n = result.exact ? std::exp2(differing.size()) : kSignFlipDraws + 1;
  result.p_above = static_cast<double>(counts.above) / n;
  result.p_below = static_cast<double>(counts.below) / n;
  return result;
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

}  // namespace uniquadric
