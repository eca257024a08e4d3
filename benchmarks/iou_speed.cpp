// Time of one 3D IoU: exact, and by 100,000 Monte Carlo samples.
#include <benchmark/benchmark.h>

#include <vector>

#include "evaluation/iou/ellipsoid_iou.h"
#include "evaluation/iou/monte_carlo.h"
#include "tests/evaluation/random_ellipsoid.h"

namespace {

using namespace uniquadric;

using Pair = std::pair<Ellipsoid, Ellipsoid>;

// Bodies that overlap, most of them in part, with axes up to three times as long as one another.
std::vector<Pair> overlapping_pairs() {
  std::vector<Pair> pairs;
  for (std::uint64_t i = 0; i < 256; ++i) {
    RandomStream random(1, "iou_speed", i);
    const Ellipsoid a = random_ellipsoid(random, 0.3, 3);
    pairs.emplace_back(a, random_ellipsoid(random, 0.3, 3));
  }
  return pairs;
}

template <typename Iou>
void over_pairs(benchmark::State& state, Iou iou) {
  const auto pairs = overlapping_pairs();
  std::size_t i = 0;
  for (auto _ : state) {
    const auto& [a, b] = pairs[i++ % pairs.size()];
    benchmark::DoNotOptimize(iou(a, b));
  }
}

void exact(benchmark::State& state) {
  over_pairs(state, ellipsoid_iou);
}
BENCHMARK(exact)->Unit(benchmark::kMillisecond);

void monte_carlo(benchmark::State& state) {
  const BallSamples samples(100'000, 1);
  over_pairs(state, [&](const Ellipsoid& a, const Ellipsoid& b) {
    return ellipsoid_iou_monte_carlo(a, b, samples);
  });
}
BENCHMARK(monte_carlo)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
