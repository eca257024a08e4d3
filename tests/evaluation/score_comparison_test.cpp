#include "evaluation/comparison/score_comparison.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/evaluation/comparison_fixture.h"

namespace uniquadric {
namespace {

constexpr double kRounding = 1e-12;
constexpr double kNoise = 0.04;  // of ln(error), of a run

TEST(ScoreComparison, MeansAreOverSequencesThenSeedsThenObjects) {
  const std::string ape = "ape_translation_rmse_m", iou = "iou3d_ellipsoid_mean";
  // s1: seed 1 of two objects (ln 2 and ln 8: ln 4), seed 2 no loss; s2: one seed, ln 16
  std::vector<FabricatedScore> a = {{"s1", "cube", "v", 1, ape, 1},   {"s1", "ball", "v", 1, ape, 1},
                                    {"s1", "cube", "v", 2, ape, 1},   {"s2", "cube", "v", 1, ape, 1},
                                    {"s1", "camera", "v", 1, ape, 1}, {"s1", "cube", "v", 1, iou, 0.9}};
  auto b = a;
  b[0].value = 2;
  b[1].value = 8;
  b[3].value = 16;
  b[5].value = 0.7;
  const ScoreComparison c = compare(a, b);
  ASSERT_EQ(c.metrics.size(), 3u);
  const MetricChange& change = find(c, ape).subjects == "objects" ? find(c, ape) : c.metrics.back();
  ASSERT_EQ(change.subjects, "objects");
  EXPECT_NEAR(change.loss, (std::log(4) / 2 + std::log(16)) / 2, kRounding);
  EXPECT_NEAR(change.b / change.a, std::exp(change.loss), 1e-9);
  EXPECT_NEAR(change.noise, std::hypot(std::log(4) / 4, std::log(16) / 2), kRounding);
  EXPECT_EQ(change.sequences, 2u);
  EXPECT_EQ(change.pairs, 3u);
  EXPECT_EQ(change.test.differing, 2u);
  EXPECT_EQ(change.test.p_above, 0.25);
  EXPECT_EQ(change.verdict, Verdict::not_judged);  // three pairs prove nothing
  EXPECT_EQ(change.reason, VerdictReason::few_pairs);
  EXPECT_NEAR(find(c, iou).loss, 0.2, kRounding);
  EXPECT_NEAR(find(c, iou).b, 0.7, kRounding);
  EXPECT_EQ(change.places.front().sequence, "s2");
}

// Of five seeds each pair loses half: p = 1/32 either way.
TEST(ScoreComparison, OneSequenceNeedsEightSeeds) {
  for (const std::uint64_t seeds : {5, 8}) {
    std::vector<FabricatedScore> a;
    for (std::uint64_t seed = 1; seed <= seeds; ++seed)
      a.push_back({"s1", "cube", "v", seed, "d_shape_mean_m", 0.1 * static_cast<double>(seed)});
    auto b = a;
    scale(b, "d_shape_mean_m", 1.5);
    EXPECT_EQ(compare(a, b).metrics[0].verdict, seeds == 5 ? Verdict::not_judged : Verdict::worse);
    EXPECT_EQ(compare(b, a).metrics[0].verdict, seeds == 5 ? Verdict::not_judged : Verdict::better);
    for (const FabricatedScore& score : std::vector(b)) {  // of two sequences they are enough
      b.push_back(score);
      b.back().sequence = "s2";
      a.push_back(b.back());
      a.back().value /= 1.5;
    }
    EXPECT_EQ(compare(a, b).metrics[0].verdict, Verdict::worse);
  }
}

TEST(ScoreComparison, SmallLossOfOnePlaceIsSuspect) {
  const auto a = fabricated_scores(0, 1);
  for (const auto& [factor, verdict] : {std::pair(1.015, Verdict::no_proven_change),
                                        std::pair(1.06, Verdict::suspect), std::pair(1.3, Verdict::worse)}) {
    auto b = a;
    scale(b, "d_shape_mean_m", 0.999);  // elsewhere it is better
    scale(b, "d_shape_mean_m", factor, "s3");
    EXPECT_EQ(find(compare(a, b), "d_shape_mean_m").verdict, verdict) << factor;
  }
}

TEST(ScoreComparison, ZerosOfErrorsAndCounts) {
  const auto loss_of = [](const std::string& metric, double a, double b) {
    return loss(change_rule(metric, is_lower_better(metric)), a, b);
  };
  EXPECT_EQ(loss_of("ape_translation_rmse_m", 0, 0), 0);
  EXPECT_EQ(loss_of("ape_translation_rmse_m", 0, 3e-16), 0);  // rounding of what is exactly right
  EXPECT_NEAR(loss_of("ape_translation_rmse_m", 0, 1e-3), std::log(1e6), kRounding);
  EXPECT_NEAR(loss_of("ape_translation_rmse_m", 1e-3, 0), -std::log(1e6), kRounding);
  EXPECT_NEAR(loss_of("ape_translation_rmse_m", 0.1, 0.102), std::log(1.02), kRounding);
  EXPECT_EQ(loss_of("id_switches", 0, 2), 2);
  EXPECT_EQ(loss_of("false_bodies", 0, 3), 3);
  EXPECT_NEAR(change_rule("false_bodies", true).margin, 0.1, kRounding);
  EXPECT_NEAR(loss_of("longest_gap_s", 0.5, 0.25), -0.25, kRounding);
  EXPECT_EQ(loss_of("semi_axes_change_occluded_max", 0, 0.25), 0.25);
  EXPECT_EQ(loss_of("coverage", 0.75, 0.5), 0.25);
  EXPECT_NEAR(change_rule("iou3d_ellipsoid_mean", false).margin, 0.005, kRounding);
  EXPECT_NEAR(change_rule("d_shape_mean_m", true).margin, std::log(1.02), kRounding);
}

// What counts as 1e-9 in a ratio is shown as it is.
TEST(ScoreComparison, AnErrorOfNothingIsShownAsNothing) {
  const auto of_value = [](double value) {
    auto scores = fabricated_scores(0, 1);
    for (FabricatedScore& score : scores)
      if (score.metric == "d_shape_mean_m") score.value = value;
    return scores;
  };
  EXPECT_EQ(find(compare(of_value(0), of_value(0)), "d_shape_mean_m").a, 0);
  EXPECT_NEAR(find(compare(of_value(3e-16), of_value(0)), "d_shape_mean_m").a, 3e-16, 1e-28);
  const std::string text = comparison_text(compare(of_value(0), of_value(0.01)));
  EXPECT_NE(text.find("d_shape_mean_m  objects  0  0.0100  from none"), std::string::npos) << text;
  const MetricChange mended = find(compare(of_value(0.01), of_value(0)), "d_shape_mean_m");
  EXPECT_NEAR(mended.a, 0.01, kRounding);
  EXPECT_EQ(mended.b, 0);
}

// Of a metric that one side knows nowhere, the name; of figures that are missing here and there, the names.
TEST(ScoreComparison, NamesMetricsThatOneSideLacks) {
  const auto a = fabricated_scores(0, 1);
  auto b = a;
  std::erase_if(b, [](const FabricatedScore& score) {
    return score.metric == "iou2d_mean" ||
           (score.sequence == "s2" && score.seed == 3 && score.metric != "coverage");
  });
  for (FabricatedScore& score : b)
    if (score.metric == "d_shape_mean_m") score.metric = "d_mean_m";
  const ScoreComparison c = compare(a, b);
  EXPECT_EQ(c.pairing.metrics_of_a_alone, (std::vector<std::string>{"d_shape_mean_m", "iou2d_mean"}));
  EXPECT_EQ(c.pairing.metrics_of_b_alone, std::vector<std::string>{"d_mean_m"});
  for (const std::string& text : {comparison_text(c), comparison_markdown(c)}) {
    EXPECT_NE(text.find("metrics of A alone:\n"), std::string::npos) << text;
    EXPECT_NE(text.find("d_shape_mean_m\n"), std::string::npos) << text;
    EXPECT_NE(text.find("s1/cube v seeds 1-8: d_shape_mean_m, iou2d_mean\n"), std::string::npos) << text;
    EXPECT_NE(text.find("s2/cube v seed 3: ape_rotation_rmse_rad, ape_translation_rmse_m, d_shape_mean_m, "
                        "id_switches and 3 more\n"),
              std::string::npos)
        << text;
  }
  const nlohmann::json json = nlohmann::json::parse(comparison_json(c));
  EXPECT_EQ(json["metrics_of_a_alone"].size(), 2u);
  EXPECT_EQ(json["metrics_of_b_alone"].size(), 1u);
  // a side without any figure lacks them all: its runs are named
  EXPECT_TRUE(compare(a, {}).pairing.metrics_of_a_alone.empty());
}

// The same values as each metric: another switch in every run fails, one in twenty does not.
TEST(ScoreComparison, CountsHaveAMarginOfTheirOwn) {
  const auto a = fabricated_scores(0, 1);
  for (const auto& [every, answer] : {std::pair(1, GateAnswer::worse), std::pair(20, GateAnswer::pass)}) {
    auto b = a;
    int run = 0;
    for (FabricatedScore& score : b)
      if (score.metric == "id_switches" && run++ % every == 0) score.value += 1;
    EXPECT_EQ(compare(a, b).answer, answer) << every;
  }
}

TEST(ScoreComparison, TimeFailsNothingUnlessAsked) {
  auto a = fabricated_scores(0, 1);
  for (FabricatedScore& score : a)
    if (score.metric == "d_shape_mean_m") score.metric = "frame_time_mean_ms";
  auto b = a;
  scale(b, "frame_time_mean_ms", 1.5);
  const ScoreComparison c = compare(a, b);
  EXPECT_EQ(c.answer, GateAnswer::pass);
  EXPECT_EQ(find(c, "frame_time_mean_ms").reason, VerdictReason::time_only);
  GateOptions options;
  options.gate_time = true;
  EXPECT_EQ(compare(a, b, options).answer, GateAnswer::worse);
}

TEST(ScoreComparison, TimeThatOneSideLacksIsNoFailure) {
  auto a = fabricated_scores(0, 1);
  for (const char* name : {"frame_time_mean_ms", "cpu_time_s", "wall_time_s", "peak_memory_mb"})
    a.push_back({"s1", "all", "v", 1, name, 3});
  auto failed = a;
  for (std::size_t i = a.size() - 4; i < a.size(); ++i) failed[i].failed = true;
  GateOptions options;
  options.gate_time = true;
  for (const auto& b : {fabricated_scores(0, 1), failed})
    for (const ScoreComparison& c : {compare(a, b, options), compare(b, a, options)}) {
      EXPECT_EQ(c.answer, GateAnswer::pass);
      EXPECT_TRUE(c.pairing.new_failures.empty());
    }
}

// What A knows nowhere is new; what B lacks is missing.
TEST(ScoreComparison, WhatBAloneHasIsNew) {
  const auto a = fabricated_scores(0, 1);
  auto b = a;
  b.push_back({"s1", "cube", "v", 1, "fresh_m", 1});
  b.push_back({"s7", "cube", "v", 1, "iou3d_ellipsoid_mean", 0.5, true});
  b.push_back({"s1", "cube", "w", 1, "iou3d_ellipsoid_mean", 0.5});
  const ScoreComparison c = compare(a, b), back = compare(b, a);
  EXPECT_EQ(c.answer, GateAnswer::pass);
  EXPECT_EQ(c.pairing.new_in_b, 3u);
  const std::string text = comparison_text(c);
  for (const char* line : {"new metrics (of B alone):\n  fresh_m\n", "new scenes (of B alone):\n  s7\n",
                           "new variants (of B alone):\n  w\n"})
    EXPECT_NE(text.find(line), std::string::npos) << text;
  EXPECT_EQ(back.answer, GateAnswer::incomplete);
  b = a;
  b.push_back({"s1", "cube", "v", 9, "iou3d_ellipsoid_mean", 0.5});
  EXPECT_EQ(compare(a, b).answer, GateAnswer::incomplete);  // a seed more of a scene that is known
}

TEST(ScoreComparison, BetterIsSaid) {
  auto b = noisy(kNoise, 0);
  scale(b, "ape_translation_rmse_m", 0.9);
  const ScoreComparison c = compare(noisy(kNoise, 1), b);
  EXPECT_EQ(c.answer, GateAnswer::pass);
  EXPECT_EQ(find(c, "ape_translation_rmse_m").verdict, Verdict::better);
}

// Metrics in which nothing differs are none that a p is corrected for; those that differ are.
TEST(ScoreComparison, HolmCountsMetricsThatDiffer) {
  auto b = fabricated_scores(0, 1);
  scale(b, "ape_translation_rmse_m", 1.3, "s1");  // 8 pairs: p = 1/256
  const ScoreComparison alone = compare(fabricated_scores(0, 1), b);
  EXPECT_DOUBLE_EQ(*find(alone, "ape_translation_rmse_m").p_worse, 1.0 / 256);
  scale(b, "ape_rotation_rmse_rad", 0.9);
  scale(b, "iou2d_mean", 1.01);
  const ScoreComparison three = compare(fabricated_scores(0, 1), b);
  EXPECT_DOUBLE_EQ(*find(three, "ape_translation_rmse_m").p_worse, 3.0 / 256);
  EXPECT_EQ(find(three, "coverage").p_worse, std::nullopt);
}

TEST(ScoreComparison, WorstComesFirstInEveryForm) {
  auto b = noisy(kNoise, 0);
  scale(b, "iou2d_mean", 0.5);
  scale(b, "ape_rotation_rmse_rad", 1.1);
  b[5].failed = true;
  b.pop_back();
  const ScoreComparison c = compare(noisy(kNoise, 0), b);
  const std::string text = comparison_text(c), markdown = comparison_markdown(c);
  EXPECT_LT(text.find("worse    iou2d_mean"), text.find("worse    ape_rotation_rmse_rad"));
  EXPECT_NE(text.find("+10 %"), std::string::npos) << text;
  EXPECT_NE(text.find("s1/cube v seed 1: iou2d_mean"), std::string::npos) << text;
  EXPECT_EQ(text.find("no proven change  "), std::string::npos);
  EXPECT_TRUE(
      text.ends_with("worse: of 8 metrics 2 worse, 0 suspect, 0 better, 6 with no proven change; 1 new "
                     "failure; 1 missing in B\n"))
      << text;
  EXPECT_TRUE(markdown.starts_with("**worse: of 8 metrics")) << markdown;
  EXPECT_NE(markdown.find("| worse | iou2d_mean | objects |"), std::string::npos) << markdown;
  EXPECT_NE(markdown.find("| no proven change | coverage | objects |"), std::string::npos) << markdown;
}

// Three seeds of s9 lose more than the eight of s3, which prove it.
TEST(ScoreComparison, TableNamesThePlaceThatDecided) {
  auto a = fabricated_scores(0, 1);
  for (std::uint64_t seed = 1; seed <= 3; ++seed)
    a.push_back({"s9", "cube", "v", seed, "d_shape_mean_m", 0.1});
  auto b = a;
  scale(b, "d_shape_mean_m", 0.8);
  scale(b, "d_shape_mean_m", 1.5, "s3");
  scale(b, "d_shape_mean_m", 2, "s9");
  const std::string text = comparison_text(compare(a, b));
  EXPECT_NE(text.find("of one object  s3/cube +20 % (p 0.004)"), std::string::npos) << text;
}

TEST(ScoreComparison, PIsPrintedDownToWhatTheTestResolves) {
  const auto a = fabricated_scores(0, 1);
  auto b = a;
  scale(b, "d_shape_mean_m", 1.5);  // 48 pairs, every one lost: one in 100,001 flips
  const std::string text = comparison_text(compare(a, b));
  EXPECT_NE(text.find("+50 %  < 0.0001"), std::string::npos) << text;
}

TEST(ScoreComparison, JsonHasEveryMetricAndReadsBack) {
  const auto a = noisy(kNoise, 0), b = noisy(kNoise, 1);
  const ScoreComparison c = compare(a, b);
  const std::string text = comparison_json(c);
  const nlohmann::json json = nlohmann::json::parse(text);
  EXPECT_EQ(json["answer"], "pass");
  ASSERT_EQ(json["metrics"].size(), 8u);
  for (std::size_t i = 0; i < c.metrics.size(); ++i) {
    EXPECT_EQ(json["metrics"][i]["loss"], c.metrics[i].loss);
    EXPECT_EQ(json["metrics"][i]["p_worse"], c.metrics[i].test.p_above);
    EXPECT_EQ(json["metrics"][i]["places"].size(), 6u);
  }
  for (const auto& metric : json["metrics"])
    EXPECT_EQ(metric["p_worse_holm"].is_null(), metric["pairs_differing"] == 0) << metric["metric"];
  auto shuffled = b;
  std::reverse(shuffled.begin(), shuffled.end());
  EXPECT_EQ(text, comparison_json(compare(a, shuffled)));
}

}  // namespace
}  // namespace uniquadric
