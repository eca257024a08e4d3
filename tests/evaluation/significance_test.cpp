#include "evaluation/comparison/significance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/base/random.h"

namespace uniquadric {
namespace {

constexpr double kRounding = 1e-12;

TEST(SignFlip, HandComputed) {
  const auto expect = [](const std::vector<double>& d, double above, double below) {
    const SignFlip result = sign_flip(d, "test");
    EXPECT_TRUE(result.exact);
    EXPECT_DOUBLE_EQ(result.p_above, above);
    EXPECT_DOUBLE_EQ(result.p_below, below);
  };
  expect({1, 1, 1}, 1.0 / 8, 1);
  expect({-1, -1, -1}, 1, 1.0 / 8);
  expect({1, 2, 3}, 1.0 / 8, 1);
  expect({3, -1}, 2.0 / 4, 3.0 / 4);           // of 4, 2, -2, -4
  expect({1, 1, -1}, 4.0 / 8, 7.0 / 8);        // of 3, 1 x 3, -1 x 3, -3
  expect({0.1, 0.2, -0.3}, 5.0 / 8, 5.0 / 8);  // of 0 twice, which rounding tells apart
  expect({1, 1, 1, 1, 1, 1, 1, 1}, 1.0 / 256, 1);
  expect({2, 1, 1, 1, 1, 1, 1, 1, 1, -1}, 10.0 / 1024, 1023.0 / 1024);  // of 11, 9 x 9, less
}

TEST(SignFlip, ZerosSayNothing) {
  const SignFlip none = sign_flip({0, 0, 0}, "test");
  EXPECT_EQ(none.differing, 0u);
  EXPECT_EQ(none.p_above, 1);
  EXPECT_EQ(none.p_below, 1);
  const SignFlip one = sign_flip(std::vector<double>{0, 0, 5, 0}, "test");
  EXPECT_EQ(one.differing, 1u);
  EXPECT_EQ(one.p_above, 0.5);
  std::vector<double> many(40, 0.0);
  many[7] = many[30] = 1;
  EXPECT_TRUE(sign_flip(many, "test").exact);
  EXPECT_EQ(sign_flip(many, "test").p_above, 0.25);
}

// All flips, one sum each.
double counted_above(const std::vector<double>& d) {
  double observed = 0, above = 0;
  for (const double value : d) observed += value;
  for (std::uint32_t flips = 0; flips < 1u << d.size(); ++flips) {
    double sum = 0;
    for (std::size_t i = 0; i < d.size(); ++i) sum += flips >> i & 1 ? -d[i] : d[i];
    above += sum >= observed - 1e-9;
  }
  return above / std::exp2(d.size());
}

std::vector<double> normal_values(std::size_t n, double mean) {
  RandomStream random(3, "values", n);
  std::vector<double> values;
  for (std::size_t i = 0; i < n; ++i) values.push_back(mean + random.normal());
  return values;
}

TEST(SignFlip, ExactAsCountedOneByOne) {
  for (const std::size_t n : {1, 7, 8, 9, 13, 17}) {
    const std::vector<double> d = normal_values(n, 0.3);
    EXPECT_NEAR(sign_flip(d, "test").p_above, counted_above(d), kRounding) << n;
  }
}

TEST(SignFlip, DrawnNearTheExact) {
  const std::vector<double> d = normal_values(21, 0.4);
  const SignFlip drawn = sign_flip(d, "test");
  EXPECT_FALSE(drawn.exact);
  const double exact = counted_above(d);
  EXPECT_NEAR(drawn.p_above, exact, 4 * std::sqrt(exact * (1 - exact) / kSignFlipDraws));
  EXPECT_NE(drawn.p_above, exact);
  EXPECT_EQ(drawn.p_above, sign_flip(d, "test").p_above);
  EXPECT_NE(drawn.p_above, sign_flip(d, "another").p_above);
}

TEST(SignFlip, DrawnIsNever0) {
  const SignFlip result = sign_flip(std::vector<double>(70, 1.0), "test");  // three words a draw
  EXPECT_DOUBLE_EQ(result.p_above, 1.0 / 100'001);
  EXPECT_DOUBLE_EQ(result.p_below, 1);
}

// Of ten differences the p turns at the shift, exact or drawn.
TEST(ProvableShift, IsWhereTheTestTurns) {
  for (const std::size_t n : {10, 30}) {
    const std::vector<double> d = normal_values(n, 0), weights(n, 1.0 / static_cast<double>(n));
    const double shift = *provable_shift(d, weights, 0.01, "test");
    for (const double step : {-1e-6, 1e-6}) {
      std::vector<double> shifted = d;
      for (double& value : shifted) value += (shift + step) / static_cast<double>(n);
      EXPECT_EQ(sign_flip(shifted, "test").p_above <= 0.01, step > 0) << n;
    }
  }
}

TEST(ProvableShift, NeedsEnoughPairs) {
  const std::vector<double> d = {0.1, -0.1, 0.1}, weights = {1, 1, 1};
  EXPECT_DOUBLE_EQ(least_p(3), 1.0 / 8);
  EXPECT_FALSE(provable_shift(d, weights, 0.12, "test"));
  EXPECT_NEAR(*provable_shift(d, weights, 0.125, "test"), 0.1, kRounding);  // all must have lost
}

TEST(Holm, LevelIsWhereTheCorrectedPTurns) {
  EXPECT_DOUBLE_EQ(holm_level({}, 0.03), 0.03);
  EXPECT_DOUBLE_EQ(holm_level({0.5, 0.9}, 0.03), 0.01);
  EXPECT_DOUBLE_EQ(holm_level({0.5, 0.001}, 0.03), 0.015);   // one is rejected before
  EXPECT_DOUBLE_EQ(holm_level({0.014, 0.001}, 0.03), 0.03);  // both are
}

TEST(Tarone, LeavesOutWhatProvesNothing) {
  EXPECT_DOUBLE_EQ(tarone_level(std::vector<double>(30, 1.0 / 64), 0.03), 0.015);  // none is able
  std::vector<double> least(20, 1e-5);
  least.insert(least.end(), 30, 0.5);
  EXPECT_DOUBLE_EQ(tarone_level(least, 0.03), 0.03 / 20);
}

TEST(Holm, HandComputed) {
  EXPECT_EQ(holm({}), std::vector<double>{});
  EXPECT_EQ(holm({0.7}), std::vector<double>{0.7});
  const std::vector<double> corrected = holm({0.01, 0.04, 0.03, 0.005});
  const std::vector<double> expected = {0.03, 0.06, 0.06, 0.02};
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_NEAR(corrected[i], expected[i], kRounding) << i;
  EXPECT_EQ(holm({0.6, 0.9}), (std::vector<double>{1, 1}));
}

}  // namespace
}  // namespace uniquadric
