#include "core/base/random.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <set>
#include <vector>

#include "core/base/philox.h"

namespace uniquadric {
namespace {

constexpr int kDraws = 100'000;

TEST(RandomStream, SameKeySameNumbersAnyOtherKeyOthers) {
  RandomStream a(7, "depth", 3, 1), b(7, "depth", 3, 1);
  const auto first = a.bits();
  EXPECT_EQ(first, b.bits());
  std::set<std::uint32_t> seen{first};
  seen.insert(RandomStream(8, "depth", 3, 1).bits());
  seen.insert(RandomStream(7, "image", 3, 1).bits());
  seen.insert(RandomStream(7, "depth", 4, 1).bits());
  seen.insert(RandomStream(7, "depth", 3, 2).bits());
  seen.insert(RandomStream(7, "depth", std::uint64_t{3} << 32, 1).bits());
  EXPECT_EQ(seen.size(), 6u);
}

TEST(RandomStream, NormalHasTheMomentsOfANormal) {
  RandomStream random(1, "moments");
  double m1 = 0, m2 = 0, m3 = 0, m4 = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double x = random.normal();
    m1 += x, m2 += x * x, m3 += x * x * x, m4 += x * x * x * x;
  }
  // Standard errors of the moments of n normals: 1, sqrt 2, sqrt 15, sqrt 96 over sqrt n; 5 of them.
  const double unit = 5 / std::sqrt(kDraws);
  EXPECT_NEAR(m1 / kDraws, 0, unit);
  EXPECT_NEAR(m2 / kDraws, 1, std::sqrt(2) * unit);
  EXPECT_NEAR(m3 / kDraws, 0, std::sqrt(15) * unit);
  EXPECT_NEAR(m4 / kDraws, 3, std::sqrt(96) * unit);
}

TEST(RandomStream, FillDrawsTheSameNumbersAsBits) {
  RandomStream one(7, "fill", 3, 2), many(7, "fill", 3, 2);
  int filled = 0;
  for (const std::size_t size : {1u, 0u, 2u, 31u, 32u, 33u, 200u, 5u}) {  // starts at every place of a block
    std::vector<std::uint32_t> values(size);
    many.fill(values);
    for (const std::uint32_t value : values) ASSERT_EQ(value, one.bits());
    EXPECT_EQ(many.bits(), one.bits());
    filled += static_cast<int>(size);
  }
  EXPECT_EQ(filled, 304);
}

// Answers of its authors' kat_vectors (Random123).
TEST(Philox, GivesItsKnownAnswers) {
  using Block = std::array<std::uint32_t, 4>;
  EXPECT_EQ(philox({0, 0, 0, 0}, {0, 0}), (Block{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
  constexpr std::uint32_t kOnes = 0xffffffff;
  EXPECT_EQ(philox({kOnes, kOnes, kOnes, kOnes}, {kOnes, kOnes}),
            (Block{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
  EXPECT_EQ(philox({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}),
            (Block{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

// On a processor with AVX2 the lanes are computed by it, and a block by itself never is.
TEST(Philox, LanesAreTheBlocksOneByOne) {
  const std::array<std::uint32_t, 2> key{7, 0xdeadbeef};
  for (const std::uint32_t first : {0u, 12345u, 0xfffffff8u}) {  // the last one wraps around
    const std::array<std::uint32_t, 4> counter{first, 1, 2, 3};
    std::array<std::uint32_t, 4 * kPhiloxLanes> lanes{};
    philox_lanes(counter, key, lanes.data());
    for (std::uint32_t i = 0; i < kPhiloxLanes; ++i) {
      const auto block = philox({first + i, 1, 2, 3}, key);
      for (std::uint32_t k = 0; k < 4; ++k) EXPECT_EQ(lanes[4 * i + k], block[k]) << first << ' ' << i;
    }
  }
}

TEST(RandomStream, UniformAndBelowFillTheirRangesEvenly) {
  RandomStream random(1, "ranges");
  std::array<int, 7> counts{};
  for (int i = 0; i < kDraws; ++i) {
    const double u = random.uniform();
    ASSERT_GT(u, 0);
    ASSERT_LT(u, 1);
    ++counts[random.below(7)];
  }
  double chi_square = 0;
  for (const int count : counts) chi_square += std::pow(count - kDraws / 7.0, 2) / (kDraws / 7.0);
  EXPECT_LT(chi_square, 27.9);  // 6 degrees of freedom, p = 1e-4
}

}  // namespace
}  // namespace uniquadric
