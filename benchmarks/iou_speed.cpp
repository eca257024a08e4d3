// Time of one 3D IoU: exact, by 100,000 Monte Carlo samples, and by the arithmetic of these samples alone:
// the same operations on what registers hold, as wide as the compiler's baseline has them, and nothing is
// loaded.
#include <benchmark/benchmark.h>
#include <emmintrin.h>

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

constexpr int kSamples = 100'000;

void monte_carlo(benchmark::State& state) {
  const BallSamples samples(kSamples, 1);
  over_pairs(state, [&](const Ellipsoid& a, const Ellipsoid& b) {
    return ellipsoid_iou_monte_carlo(a, b, samples);
  });
}
BENCHMARK(monte_carlo)->Unit(benchmark::kMillisecond);

// |center + axes * point|^2 <= 1, counted, two points at a time. The empty statement makes the points new
// ones in the compiler's eyes.
void monte_carlo_arithmetic(benchmark::State& state) {
  const __m128d center = _mm_set1_pd(0.1), axes = _mm_set1_pd(0.8), one = _mm_set1_pd(1);
  __m128d x = _mm_set1_pd(0.3), y = _mm_set1_pd(0.4), z = _mm_set1_pd(0.5);
  const auto square = [&](__m128d p) {
    const __m128d moved = _mm_add_pd(center, _mm_mul_pd(axes, p));
    return _mm_mul_pd(moved, moved);
  };
  for (auto _ : state) {
    __m128i inside = _mm_setzero_si128();
    for (int i = 0; i < kSamples; i += 2) {
      asm volatile("" : "+x"(x), "+x"(y), "+x"(z));
      const __m128d sum = _mm_add_pd(_mm_add_pd(square(x), square(y)), square(z));
      inside = _mm_sub_epi64(inside, _mm_castpd_si128(_mm_cmple_pd(sum, one)));
    }
    benchmark::DoNotOptimize(inside);
  }
}
BENCHMARK(monte_carlo_arithmetic)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
