// What a report says of a bench with more scenes than it shows.
#include "evaluation/report/overview.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/base/files.h"
#include "evaluation/report/page.h"
#include "evaluation/results/scores.h"
#include "tests/evaluation_report/fabricated_results.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {

constexpr std::size_t kAll = 1'000'000;

// The fabricated scenes as those of two families, `count` scenes each, one run of which failed.
Results many_scenes(const TempFolder& folder, int count) {
  fabricate_results(folder.path(), {.frames = 20, .overlays = 0, .with_failure = false});
  const std::vector<Cell> cells = read_cells(folder.path() / "cells.csv");
  std::ofstream file(folder.path() / "cells.csv");
  file << "scene,variant,seed,status,folder,message\n";
  for (const char* family : {"far", "near"})
    for (int i = 0; i < count; ++i)
      for (const Cell& cell : cells) {
        if (cell.scene != cells.front().scene) continue;
        const bool fails =
            i == 3 && std::string(family) == "near" && cell.variant == "rotbbox" && cell.seed == 1;
        file << family << '_' << 1000 + i << ',' << cell.variant << ',' << cell.seed
             << (fails ? ",failed," : ",ok,") << cell.folder.string() << ",\n";
      }
  file.close();
  return read_results(folder.path());
}

Overview overview(const TempFolder& folder, std::size_t most_rows, std::size_t most_judged = kAll) {
  std::ostringstream scores;
  return overview_of(folder.path(), most_rows, most_judged, scores);
}

TEST(Overview, WritesTheScoresOfAllScenes) {
  const TempFolder folder;
  const Results results = many_scenes(folder, 4);
  std::ostringstream written;
  const Overview all = overview_of(folder.path(), 1, kAll, written);
  EXPECT_EQ(written.str(), scores_csv(scores(results)));
  EXPECT_EQ(all.scenes, 8u);
  EXPECT_EQ(all.objects, 8u * 2);
  EXPECT_EQ(all.runs, 8u * 4);
  EXPECT_EQ(all.failed, 1u);
}

TEST(Overview, ShowsAllScenesThatFit) {
  const TempFolder folder;
  many_scenes(folder, 4);
  EXPECT_EQ(overview(folder, kAll).shown.size(), 8u);
  EXPECT_TRUE(overview(folder, kAll).rows.empty());
  const std::size_t rows = summarize(read_results(folder.path(), std::set<std::string>{"far_1000"})).size();
  const Overview some = overview(folder, 3 * rows);
  EXPECT_EQ(some.shown.size(), 3u);
  EXPECT_TRUE(some.shown.contains("near_1003"));  // a run failed there
  EXPECT_EQ(overview(folder, 1).shown, std::set<std::string>{"near_1003"});
}

TEST(Overview, RowsAreMediansOverAllObjectsAndOverFamilies) {
  const TempFolder folder;
  const Results results = many_scenes(folder, 4);
  const Overview some = overview(folder, 1);
  for (const std::string scene : {"all", "far", "near"})
    for (const std::string variant : {"rotbbox", "single_frame_obb"}) {
      std::vector<double> medians;
      int good = 0;
      for (const SummaryRow& row : summarize(results))
        if (row.variant == variant && row.object != "camera" && row.object != "all" &&
            (scene == "all" || row.scene.starts_with(scene))) {
          medians.push_back(row.spread.at("ape_translation_rmse_m").median);
          good += row.good;
        }
      const auto row = std::ranges::find_if(
          some.rows, [&](const SummaryRow& r) { return r.scene == scene && r.variant == variant; });
      ASSERT_NE(row, some.rows.end()) << scene << variant;
      EXPECT_EQ(row->spread.at("ape_translation_rmse_m").median, median(medians));
      EXPECT_EQ(row->spread.at("ape_translation_rmse_m").n, static_cast<int>(medians.size()));
      EXPECT_EQ(row->good, good);
      EXPECT_EQ(row->runs, scene == "all" ? 8 * 2 * 2 : 4 * 2 * 2);
    }
}

TEST(Overview, VerdictsAreOfAllScenes) {
  const TempFolder folder;
  const Results results = many_scenes(folder, 4);
  const auto whole = variant_verdicts(results);
  const Overview some = overview(folder, 1);
  ASSERT_EQ(some.verdicts.size(), whole.size());
  for (std::size_t i = 0; i < whole.size(); ++i) {
    EXPECT_EQ(some.verdicts[i].objects.size(), whole[i].objects.size());
    EXPECT_EQ(some.verdicts[i].metrics.front().a, whole[i].metrics.front().a);
    EXPECT_EQ(some.verdicts[i].metrics.front().pairs, whole[i].metrics.front().pairs);
  }
}

// So that the gate's memory has a bound: it keeps all that it judges.
TEST(Overview, VerdictsOfMoreRunsThanFitAreOfScenesSpreadEvenly) {
  const TempFolder folder;
  const Results results = many_scenes(folder, 4);  // four runs a scene
  const Overview some = overview(folder, 1, 3 * 4), one = overview(folder, 1, 1);
  std::set<std::string> judged;
  for (const ObjectChange& change : some.verdicts.front().objects) judged.insert(change.scene);
  EXPECT_EQ(judged, (std::set<std::string>{"far_1000", "near_1000", "near_1003"}));
  EXPECT_EQ(some.judged, 3u);
  EXPECT_NE(page_markdown(results, summarize(results), some).find("are of 3 of 8 scenes"), std::string::npos);
  EXPECT_EQ(one.judged, 1u);
  EXPECT_EQ(overview(folder, 1, 8 * 4).judged, 8u);
  EXPECT_EQ(judged_note(overview(folder, 1)), "");
}

// So that a page with a thousand scenes is hardly larger than one with a few.
TEST(Overview, ThePageShowsSomeScenesAndCountsAll) {
  const TempFolder folder;
  many_scenes(folder, 30);
  const Overview some = overview(folder, 20);
  const Results shown = read_results(folder.path(), some.shown);
  const std::string text = page_data(shown, summarize(shown), some, {});
  const nlohmann::json data = nlohmann::json::parse(text);
  EXPECT_EQ(data.at("counts").at("scenes"), 60);
  EXPECT_EQ(data.at("overall").size(), 3u * 2);
  EXPECT_LE(data.at("summary").size(), 20u);
  for (const auto& verdict : data.at("verdicts")) {
    int objects = 0;
    for (const auto& [name, count] : verdict.at("counts").items()) objects += count.get<int>();
    EXPECT_EQ(objects, 60 * 2);
    EXPECT_EQ(verdict.at("objects").size(), some.shown.size() * 2);
  }
  EXPECT_NE(page_markdown(shown, summarize(shown), some).find("## Over all 60 scenes"), std::string::npos);
}

// A sweep of seeds: few rows, and many runs behind each.
TEST(Overview, OfManySeedsTheFirstAloneHavePlots) {
  const TempFolder folder;
  fabricate_results(folder.path(), {.seeds = 9, .frames = 20, .overlays = 0, .with_failure = false});
  const Results few = read_results(folder.path(), std::nullopt, 10);
  int plotted = 0;
  for (const Cell& cell : few.cells) {
    EXPECT_FALSE(cell.evaluation->subjects.empty());
    plotted += !cell.evaluation->series.empty();
  }
  EXPECT_EQ(few.cells.size(), 2u * 2 * 9);
  EXPECT_EQ(plotted, 2 * 2);
  const auto summary = summarize(few);
  const nlohmann::json data = nlohmann::json::parse(page_data(few, summary, {}, {.spread_values = 4}));
  const auto& spread = data.at("summary")[0].at("spread").at("ape_translation_rmse_m");
  EXPECT_EQ(spread.at("values").size(), 4u);
  EXPECT_EQ(spread.at("n"), 9);
  EXPECT_NEAR(spread.at("max").get<double>(), summary[0].spread.at("ape_translation_rmse_m").max, 1e-5);
}

}  // namespace
}  // namespace uniquadric
