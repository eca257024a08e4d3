#include "evaluation/results/paper_ratios.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "evaluation/report/page.h"
#include "tests/evaluation_report/fabricated_results.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {

constexpr const char* kApe = "ape_translation_rmse_m";

Cell run_of(const std::string& scene, const std::string& object, const std::string& variant, double ape_m) {
  Cell cell{scene, variant, 1, CellStatus::ok, "", "", CellEvaluation{}};
  cell.evaluation->subjects = {{object, {{kApe, ape_m}, {"iou3d_ellipsoid_mean", 0.5}, {"coverage", 1}}}};
  return cell;
}

std::vector<PaperRatio> ratios_of(std::vector<Cell> cells) {
  Results results;
  results.cells = std::move(cells);
  return paper_ratios(summarize(results));
}

// Of the cube's table: 0.13 / 0.44 and so on.
TEST(PaperRatios, ThePapersRowIsItsSystemOverItsBaseline) {
  const auto rows = ratios_of(
      {run_of("cube_cuboid", "cube", "single_frame_obb", 0.2), run_of("cube_cuboid", "cube", "a", 0.05)});
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].system, "paper, UniQuadric");
  EXPECT_EQ(rows[0].baseline, "paper, single-frame baseline");
  const std::map<std::string, double> expected = {{kApe, 0.13 / 0.44},
                                                  {"ape_rotation_rmse_rad", 0.247 / 2.26},
                                                  {"rpe_translation_rmse_m", 0.103 / 0.411},
                                                  {"rpe_rotation_rmse_rad", 0.016 / 1.51}};
  EXPECT_EQ(rows[0].ratio, expected);
  EXPECT_EQ(rows[1].system, "a");
  EXPECT_EQ(rows[1].good, 1);
  const std::map<std::string, double> own = {{kApe, 0.25}};  // the paper has no IoU
  EXPECT_EQ(rows[1].ratio, own);
}

TEST(PaperRatios, DividesMediansOverSeeds) {
  std::vector<Cell> cells;
  const double baseline_m[] = {0.4, 0.1, 0.2}, own_m[] = {0.01, 0.05, 0.09};
  for (std::size_t i = 0; i < 3; ++i) {
    cells.push_back(run_of("skateboard_ball", "ball", "single_frame_obb", baseline_m[i]));
    cells.push_back(run_of("skateboard_ball", "ball", "a", own_m[i]));
  }
  EXPECT_DOUBLE_EQ(ratios_of(cells).at(1).ratio.at(kApe), 0.05 / 0.2);
}

TEST(PaperRatios, ALaterOutputIsDividedByTheSameOrElseTheCausalOne) {
  const auto run = [](const char* variant, double ape_m) {
    return run_of("cube_cuboid", "cube", variant, ape_m);
  };
  const auto rows = ratios_of({run("single_frame_obb", 0.8), run("single_frame_obb@final", 0.4),
                               run("a", 0.2), run("a@fixed_lag", 0.1), run("a@final", 0.05)});
  ASSERT_EQ(rows.size(), 4u);  // the paper's, and no baseline over itself
  EXPECT_EQ(rows[1].ratio.at(kApe), 0.25);
  EXPECT_EQ(rows[2].system, "a@fixed_lag");
  EXPECT_EQ(rows[2].baseline, "single_frame_obb");
  EXPECT_EQ(rows[2].ratio.at(kApe), 0.125);
  EXPECT_EQ(rows[3].baseline, "single_frame_obb@final");
  EXPECT_EQ(rows[3].ratio.at(kApe), 0.125);
}

TEST(PaperRatios, TheStreetHasTheBaselineByLidar) {
  const auto rows = ratios_of({run_of("subway_car", "car", "single_frame_lidar", 1),
                               run_of("subway_car", "car", "uniquadric_lidar", 0.5)});
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].ratio.at(kApe), 0.244 / 2.414);
  EXPECT_EQ(rows[1].baseline, "single_frame_lidar");
  EXPECT_EQ(rows[1].ratio.at(kApe), 0.5);
}

TEST(PaperRatios, NothingWithoutABaselineOrInScenesOfOthers) {
  EXPECT_TRUE(ratios_of({run_of("cube_cuboid", "cube", "a", 0.1)}).empty());
  EXPECT_TRUE(ratios_of({run_of("cube_cuboid", "cube", "single_frame_obb", 0.1)}).empty());
  EXPECT_TRUE(
      ratios_of({run_of("mine", "cube", "single_frame_obb", 0.1), run_of("mine", "cube", "a", 0.1)}).empty());
  Cell failed{"cube_cuboid", "single_frame_obb", 1, CellStatus::failed, "", "", std::nullopt};
  EXPECT_TRUE(ratios_of({failed, run_of("cube_cuboid", "cube", "a", 0.1)}).empty());
}

TEST(PaperRatios, APerfectBaselineHasNoRatio) {
  const auto rows = ratios_of(
      {run_of("cube_cuboid", "cube", "single_frame_obb", 0), run_of("cube_cuboid", "cube", "a", 0.1)});
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_TRUE(rows[1].ratio.empty());
}

// The fabricated errors are 0.02 of the baseline's.
TEST(PaperRatios, MarkdownAndPageHaveThem) {
  const TempFolder folder;
  fabricate_results(folder.path(), {.frames = 3, .overlays = 0});
  const Results results = read_results(folder.path());
  const auto summary = summarize(results);
  const std::string text = page_markdown(results, summary, {});
  const std::size_t at = text.find("\n## Against the paper, as ratios\n");
  ASSERT_NE(at, text.npos);
  EXPECT_NE(text.find("The paper's sequences are not ours, so only ratios compare.", at), text.npos);
  EXPECT_NE(
      text.find("| cube_cuboid | cuboid | *paper, UniQuadric* | paper, single-frame baseline |  | *0.126* "
                "| *0.0603* | *0.107* | *0.0178* |\n"
                "| cube_cuboid | cuboid | rotbbox | single_frame_obb | 2/2 | 0.0200 | 0.0200 | 0.0200 | "
                "0.0200 |\n",
                at),
      text.npos)
      << text.substr(at);
  const auto data = nlohmann::json::parse(page_data(results, summary, {}, {}));
  ASSERT_EQ(data.at("ratios").size(), 4 * 2u);  // four objects: the paper's and ours
  EXPECT_EQ(data["ratios"][0].at("paper"), true);
  EXPECT_EQ(data["ratios"][1].at("system"), "rotbbox");
  EXPECT_DOUBLE_EQ(data["ratios"][1].at("ratio").at(kApe), 0.02);
}

TEST(PaperRatios, MarkdownWithoutABaselineHasNoTable) {
  Results results;
  results.cells = {run_of("cube_cuboid", "cube", "a", 0.1)};
  EXPECT_EQ(page_markdown(results, summarize(results), {}).find("Against the paper"), std::string::npos);
}

}  // namespace
}  // namespace uniquadric
