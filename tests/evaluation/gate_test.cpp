// What the gate must let pass, and what not.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/evaluation/comparison_fixture.h"

namespace uniquadric {
namespace {

constexpr int kTrials = 20;      // with noise of their own each
constexpr double kNoise = 0.04;  // of ln(error), of a run
constexpr double kSmallNoise = 0.01;

TEST(Gate, IdenticalResultsPass) {
  const ScoreComparison c = compare(noisy(kNoise, 0), noisy(kNoise, 0));
  EXPECT_EQ(c.answer, GateAnswer::pass);
  EXPECT_EQ(c.pairing.pairs.size(), 6u * 8 * 8);
  EXPECT_EQ(count_verdicts(c, Verdict::no_proven_change), 8u);
  for (const MetricChange& change : c.metrics) EXPECT_EQ(change.loss, 0);
}

TEST(Gate, FivePercentInOneMetricFails) {
  for (const char* metric : {"ape_translation_rmse_m", "d_shape_mean_m", "iou3d_ellipsoid_mean"})
    for (int trial = 0; trial < kTrials; ++trial) {
      auto b = noisy(kNoise, 2 * trial);
      scale(b, metric, is_lower_better(metric) ? 1.05 : 0.95);
      const ScoreComparison c = compare(noisy(kNoise, 2 * trial + 1), b);
      EXPECT_EQ(c.answer, GateAnswer::worse) << metric << trial;
      EXPECT_EQ(c.metrics.front().metric, metric);
      EXPECT_EQ(c.metrics.front().verdict, Verdict::worse);
    }
}

TEST(Gate, ThirtyPercentOnOneSequenceOfSixFails) {
  for (int trial = 0; trial < kTrials; ++trial) {
    auto b = noisy(kNoise, 2 * trial);
    scale(b, "rpe_translation_rmse_m", 1.3, "s4");
    const ScoreComparison c = compare(noisy(kNoise, 2 * trial + 1), b);
    EXPECT_EQ(c.answer, GateAnswer::worse) << trial;
    EXPECT_EQ(c.metrics.front().metric, "rpe_translation_rmse_m");
    EXPECT_EQ(c.metrics.front().places.front().sequence, "s4");
    EXPECT_TRUE(c.metrics.front().places.front().worse);
    EXPECT_EQ(std::count_if(c.metrics.front().places.begin(), c.metrics.front().places.end(),
                            [](const PlaceChange& place) { return place.worse; }),
              1);
  }
}

// At 0.1 a t test of the sequence's own eight seeds, corrected for the places, finds about half of them.
TEST(Gate, ThirtyPercentOnOneSequenceIsFoundInMuchNoise) {
  constexpr double kMuchNoise = 0.1 / std::numbers::sqrt2;  // of each side
  int found = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    auto b = noisy(kMuchNoise, 2 * trial);
    scale(b, "rpe_translation_rmse_m", 1.3, "s4");
    found += compare(noisy(kMuchNoise, 2 * trial + 1), b).answer == GateAnswer::worse;
  }
  EXPECT_GE(found, kTrials - 1);
}

TEST(Gate, LossOfOneSequenceIsNotHiddenByGainsElsewhere) {
  auto b = noisy(kNoise, 0);
  scale(b, "ape_rotation_rmse_rad", 0.8);
  scale(b, "ape_rotation_rmse_rad", 1.3 / 0.8, "s4");
  const ScoreComparison c = compare(noisy(kNoise, 1), b);
  EXPECT_EQ(c.answer, GateAnswer::worse);
  EXPECT_EQ(c.metrics.front().reason, VerdictReason::one_place);
  EXPECT_LT(c.metrics.front().loss, 0);
}

TEST(Gate, EightPerMillePassesAsSuspect) {
  int suspect = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    auto b = fabricated_scores(0, 1);
    scale(b, "ape_translation_rmse_m", 1.008);
    const ScoreComparison exact = compare(fabricated_scores(0, 1), b);
    EXPECT_EQ(exact.answer, GateAnswer::pass);
    EXPECT_EQ(find(exact, "ape_translation_rmse_m").verdict, Verdict::suspect);
    EXPECT_EQ(find(exact, "ape_translation_rmse_m").reason, VerdictReason::below_margin);
    b = fabricated_scores(kSmallNoise, 100 + trial);
    scale(b, "ape_translation_rmse_m", 1.008);
    const ScoreComparison c = compare(fabricated_scores(kSmallNoise, 200 + trial), b);
    EXPECT_EQ(c.answer, GateAnswer::pass) << trial;
    suspect += find(c, "ape_translation_rmse_m").verdict == Verdict::suspect;
  }
  EXPECT_GE(suspect, kTrials - 1);  // 0.8 % is 3.9 standard deviations of the mean there
}

TEST(Gate, NewFailureFails) {
  auto b = noisy(kNoise, 0);
  b[5].failed = true;
  const ScoreComparison c = compare(noisy(kNoise, 0), b);
  EXPECT_EQ(c.answer, GateAnswer::worse);
  EXPECT_EQ(c.pairing.new_failures, (std::vector<Gap>{{{"v", "s1", 1}, "cube", {b[5].metric}}}));
  const ScoreComparison back = compare(b, noisy(kNoise, 0));
  EXPECT_EQ(back.answer, GateAnswer::pass);
  EXPECT_EQ(back.pairing.mended.size(), 1u);
  EXPECT_EQ(compare(b, b).answer, GateAnswer::pass);
}

TEST(Gate, MissingCellsAreIncomplete) {
  const auto a = noisy(kNoise, 0);
  auto b = a;
  b.pop_back();
  EXPECT_EQ(compare(a, b).answer, GateAnswer::incomplete);
  EXPECT_EQ(compare(b, a).answer, GateAnswer::incomplete);
  ScoreTable not_run = table_of(a);
  not_run.not_run.insert({"v", "s7", 1});
  EXPECT_EQ(compare_scores(table_of(a), not_run).answer, GateAnswer::incomplete);
  EXPECT_EQ(compare_scores(not_run, not_run).answer, GateAnswer::incomplete);
  scale(b, "ape_translation_rmse_m", 2);
  EXPECT_EQ(compare(a, b).answer, GateAnswer::worse);  // what is proven stays proven
  auto other = a;
  for (FabricatedScore& score : other) score.variant = "w";
  EXPECT_EQ(compare(a, other).answer, GateAnswer::incomplete);
}

// 1000 comparisons of which nothing is to be said, with differences so large that no margin hides a false
// alarm; half of them with heavy tails.
TEST(Gate, FalseAlarmsStayUnderFivePercent) {
  constexpr int kComparisons = 1000;
  const std::vector<std::string> metrics = {"ape_translation_rmse_m", "ape_rotation_rmse_rad",
                                            "iou3d_ellipsoid_mean"};
  int alarms = 0;
  for (int trial = 0; trial < kComparisons; ++trial) {
    RandomStream random(9, "null", trial);
    std::vector<FabricatedScore> a, b;
    for (int sequence = 1; sequence <= 6; ++sequence)
      for (std::uint64_t seed = 1; seed <= 8; ++seed)
        for (const std::string& metric : metrics) {
          const double draw = random.normal(), d = trial % 2 ? draw * draw * draw : draw;
          const bool lower = is_lower_better(metric);
          a.push_back({fmt::format("s{}", sequence), "cube", "v", seed, metric, lower ? 0.1 : 0.5});
          b.push_back(a.back());
          b.back().value = lower ? 0.1 * std::exp(d) : 0.5 + d;
        }
    alarms += compare(a, b).answer != GateAnswer::pass;
  }
  EXPECT_LT(alarms, kComparisons / 20);
  EXPECT_GT(alarms, 0);  // the noise is large enough to raise some
}

// The same where one sequence is ten times as noisy as the others, and metrics of a run have most of their
// noise in common.
TEST(Gate, FalseAlarmsStayUnderFivePercentWhereNoiseIsUneven) {
  constexpr int kComparisons = 500;
  int alarms = 0;
  for (int trial = 0; trial < kComparisons; ++trial) {
    RandomStream random(10, "uneven", trial);
    std::vector<FabricatedScore> a, b;
    for (int sequence = 1; sequence <= 6; ++sequence)
      for (std::uint64_t seed = 1; seed <= 8; ++seed) {
        const double common = random.normal();
        for (const char* metric :
             {"ape_translation_rmse_m", "ape_rotation_rmse_rad", "rpe_translation_rmse_m"}) {
          a.push_back({fmt::format("s{}", sequence), "cube", "v", seed, metric, 0.1});
          b.push_back(a.back());
          b.back().value *= std::exp((sequence == 1 ? 1 : 0.1) * (0.9 * common + 0.4 * random.normal()));
        }
      }
    alarms += compare(a, b).answer != GateAnswer::pass;
  }
  EXPECT_LT(alarms, kComparisons / 20);
  EXPECT_GT(alarms, 0);
}

}  // namespace
}  // namespace uniquadric
