// What too few pairs cannot prove is not passed, and the smallest provable loss is what it says.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/evaluation/comparison_fixture.h"

namespace uniquadric {
namespace {

constexpr double kRounding = 1e-9;
constexpr double kNoise = 0.04;  // of ln(error), of a run
const std::string kRpe = "rpe_translation_rmse_m";

// One object, `metrics` errors that differ by noise, the first of them kRpe.
std::vector<FabricatedScore> errors(int metrics, int sequences, std::uint64_t seeds, std::uint64_t own,
                                    const std::string& variant = "v") {
  std::vector<FabricatedScore> scores;
  std::uint32_t cell = 0;
  for (int sequence = 1; sequence <= sequences; ++sequence)
    for (std::uint64_t seed = 1; seed <= seeds; ++seed)
      for (int metric = 0; metric < metrics; ++metric)
        scores.push_back({fmt::format("s{}", sequence), "cube", variant, seed,
                          metric == 0 ? kRpe : fmt::format("error_{}_m", metric),
                          0.1 * std::exp(kNoise * RandomStream(own, "errors", ++cell).normal())});
  return scores;
}

TEST(Undecided, SixPairsProveNoLossAmongThirtyMetrics) {
  auto b = errors(30, 2, 3, 2);
  scale(b, kRpe, 143);
  const ScoreComparison c = compare(errors(30, 2, 3, 1), b);
  EXPECT_EQ(c.answer, GateAnswer::undecided);
  EXPECT_EQ(count_verdicts(c, Verdict::not_judged), 30u);
  EXPECT_EQ(c.metrics.front().metric, kRpe);
  EXPECT_FALSE(c.metrics.front().provable);
  const std::string text = comparison_text(c);
  EXPECT_NE(text.find("not judged  rpe_translation_rmse_m"), std::string::npos) << text;
  EXPECT_NE(text.find("v objects, 6 pairs of 2 sequences: error_10_m"), std::string::npos) << text;
  EXPECT_NE(text.find("undecided: of 30 metrics 0 worse"), std::string::npos) << text;
}

TEST(Undecided, SixPairsOfOneMetricProveALoss) {
  auto b = errors(1, 2, 3, 2);
  scale(b, kRpe, 143);
  EXPECT_EQ(compare(errors(1, 2, 3, 1), b).answer, GateAnswer::worse);
}

TEST(Undecided, TooFewPairsWithoutALossPass) {
  const auto a = errors(30, 2, 3, 1);
  EXPECT_EQ(compare(a, a).answer, GateAnswer::pass);
}

TEST(Undecided, TwelvePairsWithoutAChangePass) {
  for (std::uint64_t trial = 1; trial <= 5; ++trial) {
    const ScoreComparison c = compare(errors(30, 3, 4, 2 * trial), errors(30, 3, 4, 2 * trial + 1));
    EXPECT_EQ(c.answer, GateAnswer::pass);
    EXPECT_EQ(count_verdicts(c, Verdict::not_judged), 0u);
    for (const MetricChange& change : c.metrics) EXPECT_TRUE(change.provable) << change.metric;
  }
}

// A recording with one seed beside scenes with many: its variant alone runs on it.
TEST(Undecided, GroupsWithFewPairsDoNotDecideBesideOthers) {
  auto a = errors(10, 3, 4, 6), b = errors(10, 3, 4, 7);
  for (auto* side : {&a, &b})
    for (const FabricatedScore& score : errors(10, 1, 1, 3, "recorded")) side->push_back(score);
  for (FabricatedScore& score : b)
    if (score.variant == "recorded") score.value *= 100;
  const ScoreComparison c = compare(a, b);
  EXPECT_EQ(c.answer, GateAnswer::pass) << comparison_text(c);
  EXPECT_EQ(count_verdicts(c, Verdict::not_judged), 10u);
  EXPECT_NE(comparison_text(c).find("recorded objects, 1 pair of 1 sequence: "), std::string::npos);
  scale(b, kRpe, 2);
  const ScoreComparison lost = compare(a, b);
  EXPECT_EQ(lost.answer, GateAnswer::worse);
  // Those that cannot prove anything cost the others nothing: the factor is 10, not 20.
  EXPECT_DOUBLE_EQ(*lost.metrics.front().p_worse, 10.0 / 4096);
}

// The same changes with another mean are worse just above it, and not proven just below.
TEST(Undecided, SmallestProvableLossIsWhereTheVerdictTurns) {
  const auto a = errors(30, 3, 4, 1), b = errors(30, 3, 4, 2);
  const MetricChange unchanged = find(compare(a, b), kRpe);
  ASSERT_TRUE(unchanged.provable);
  EXPECT_GT(*unchanged.provable, unchanged.rule.margin);
  for (const auto& [factor, verdict] :
       {std::pair(1.001, Verdict::worse), std::pair(0.999, Verdict::suspect)}) {
    auto moved = b;
    scale(moved, kRpe, std::exp(factor * *unchanged.provable - unchanged.loss));
    const MetricChange change = find(compare(a, moved), kRpe);
    EXPECT_EQ(change.verdict, verdict) << factor;
    EXPECT_NEAR(*change.provable, *unchanged.provable, kRounding);  // it does not depend on the loss
  }
}

TEST(Undecided, WithoutNoiseTheMarginIsProvable) {
  const auto a = errors(3, 3, 4, 1);
  EXPECT_NEAR(*find(compare(a, a), kRpe).provable, std::log(1.02), kRounding);
}

// Eight seeds of one sequence reach p = 1 / 256: too much for a mean among ten metrics, enough for a place.
TEST(Undecided, OnePlaceWithEnoughSeedsIsJudged) {
  auto b = errors(10, 1, 8, 2);
  EXPECT_EQ(count_verdicts(compare(errors(10, 1, 8, 1), b), Verdict::not_judged), 0u);
  scale(b, kRpe, 1.5);
  const ScoreComparison c = compare(errors(10, 1, 8, 1), b);
  EXPECT_EQ(c.answer, GateAnswer::worse);
  EXPECT_FALSE(c.metrics.front().provable);
  EXPECT_TRUE(c.metrics.front().judged_by_place);
  EXPECT_NE(comparison_text(c).find("+10 % of one"), std::string::npos) << comparison_text(c);
}

}  // namespace
}  // namespace uniquadric
