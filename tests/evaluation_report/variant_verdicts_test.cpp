#include "evaluation/comparison/variant_verdicts.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/evaluation_report/fabricated_results.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {

using Verdicts = std::vector<ObjectVerdict>;

Verdicts of_objects(const VariantVerdict& verdict) {
  Verdicts list;
  for (const ObjectChange& object : verdict.objects) list.push_back(object.verdict);
  return list;
}

Results fabricated(const TempFolder& folder, const FabricatedOptions& options) {
  fabricate_results(folder.path(), options);
  return read_results(folder.path());
}

TEST(VariantVerdicts, BothDirectionsAndFailures) {
  const TempFolder folder;
  const auto verdicts = variant_verdicts(fabricated(folder, {.frames = 20}));
  ASSERT_EQ(verdicts.size(), 2u);
  EXPECT_EQ(verdicts[0].baseline, "single_frame_obb");
  EXPECT_EQ(verdicts[0].variant, "rotbbox");
  using enum ObjectVerdict;
  EXPECT_EQ(of_objects(verdicts[0]), Verdicts({better, better, lost, lost}));  // the last cell failed
  EXPECT_EQ(of_objects(verdicts[1]), Verdicts({worse, worse, mended, mended}));
}

// The fabricated APE.t of each seed is 0.5 against 0.01 m.
TEST(VariantVerdicts, MetricsAreTheGates) {
  const TempFolder folder;
  const auto verdicts =
      variant_verdicts(fabricated(folder, {.seeds = 8, .frames = 20, .with_failure = false}));
  const auto& metrics = verdicts.at(0).metrics;
  const auto ape = std::find_if(metrics.begin(), metrics.end(), [](const MetricChange& change) {
    return change.metric == "ape_translation_rmse_m" && change.subjects == "objects";
  });
  ASSERT_NE(ape, metrics.end());
  EXPECT_EQ(ape->verdict, Verdict::better);
  EXPECT_NEAR(ape->a / ape->b, 50, 1e-6);
  EXPECT_EQ(ape->pairs, 16u);
  for (const MetricChange& change : metrics)
    EXPECT_TRUE(std::ranges::any_of(summary_metrics(), [&](const char* name) {
      return change.metric == name;
    })) << change.metric;
}

TEST(VariantVerdicts, OfManyVariantsTheFirstIsTheBaseline) {
  const TempFolder folder;
  const auto verdicts = variant_verdicts(fabricated(folder, {.frames = 20}), 1);
  ASSERT_EQ(verdicts.size(), 1u);
  EXPECT_EQ(verdicts[0].baseline, "single_frame_obb");
}

}  // namespace
}  // namespace uniquadric
