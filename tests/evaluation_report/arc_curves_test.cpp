#include "evaluation/report/arc_curves.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <regex>

#include "core/base/files.h"
#include "evaluation/report/report.h"
#include "tests/evaluation_report/small_results.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

struct Frame {
  const char *arc_deg, *iou3d;  // as they stand in frames.csv
};

// One object `cube` in scene `s`; a run each of (variant, seed).
struct Run {
  std::string variant;
  int seed;
  std::vector<Frame> frames;
};

void write_results(const fs::path& folder, const std::vector<Run>& runs) {
  std::string cells = "scene,variant,seed,status,folder,message\n";
  for (const Run& run : runs) {
    const std::string cell = fmt::format("cells/s/{}/seed_{}", cells.size(), run.seed);
    cells += fmt::format("s,{},{},ok,{},\n", run.variant, run.seed, cell);
    write_file(folder / cell / "evaluation/evaluation.json",
               R"({"schema": 1, "objects": [{"id": 1, "name": "Cube"}]})");
    std::string frames = "frame,timestamp_ns,object_id,name,matched_id,iou3d,arc_deg\n";
    for (std::size_t k = 0; k < run.frames.size(); ++k)
      frames += fmt::format("{0},{0},1,Cube,4,{1},{2}\n", k, run.frames[k].iou3d, run.frames[k].arc_deg);
    write_file(folder / cell / "evaluation/frames.csv", frames);
  }
  write_file(folder / "cells.csv", cells);
}

// Means a seed by hand: of [0, 10): 0.3, 0.5, 0.9; of [40, 180]: 0.8 and 0.6, one seed without.
const std::vector<Run> kRuns = {
    {"a", 1, {{"", ""}, {"0", "0.2"}, {"9.99", "0.4"}, {"10", ""}, {"40", "0.7"}, {"180", "0.9"}}},
    {"a", 2, {{"", "0.7"}, {"5", "0.5"}, {"50", "0.6"}}},
    {"a", 3, {{"5", "0.9"}}},
    {"b", 1, {{"20", "0.25"}}}};

TEST(ArcCurves, AreMediansOverSeedsOfMeansOverFrames) {
  const TempFolder folder;
  write_results(folder.path(), kRuns);
  const std::vector<double> edges = {0, 10, 40, 180};
  const auto curves = arc_curves(read_results(folder.path()), edges);
  ASSERT_EQ(curves.size(), 2u);
  EXPECT_EQ(curves[0].scene, "s");
  EXPECT_EQ(curves[0].object, "cube");
  EXPECT_EQ(curves[0].variant, "a");
  const auto& points = curves[0].points;
  ASSERT_EQ(points.size(), 2u);  // nothing in [10, 40)
  EXPECT_EQ(points[0].from_deg, 0);
  EXPECT_EQ(points[0].to_deg, 10);
  EXPECT_EQ(points[0].seeds, 3);
  EXPECT_NEAR(points[0].median, 0.5, 1e-12);
  EXPECT_NEAR(points[0].min, 0.3, 1e-12);
  EXPECT_NEAR(points[0].max, 0.9, 1e-12);
  EXPECT_EQ(points[1].from_deg, 40);
  EXPECT_EQ(points[1].seeds, 2);
  EXPECT_NEAR(points[1].median, 0.7, 1e-12);
  EXPECT_NEAR(points[1].min, 0.6, 1e-12);
  EXPECT_NEAR(points[1].max, 0.8, 1e-12);
  ASSERT_EQ(curves[1].points.size(), 1u);
  EXPECT_EQ(curves[1].points[0].median, 0.25);
}

TEST(ArcCurves, StandInEveryPartOfTheReport) {
  const TempFolder folder;
  write_results(folder.path(), kRuns);
  write_report(folder.path());
  const std::string markdown = read_text(folder.path() / "report.md");
  EXPECT_NE(markdown.find("| s | cube | a | 0.500 | - | - | - | 0.700 | 0.600 | - | - | 0.900 |"),
            std::string::npos)
      << markdown;
  const std::string svg = read_text(folder.path() / "iou3d_by_arc.svg");
  EXPECT_TRUE(svg.starts_with("<svg class=\"arc\" xmlns=\"http://www.w3.org/2000/svg\" viewBox="));
  EXPECT_NE(svg.find("prefers-color-scheme:dark"), std::string::npos);
  // The page has the same panels, each a picture of its own.
  const std::string page = read_text(folder.path() / "report.html");
  int panels = 0;
  for (std::size_t at = 0; (at = svg.find("<g transform=", at)) != svg.npos; ++panels) {
    const std::size_t begin = svg.find('\n', at) + 1;
    at = svg.find("</g>", at);
    EXPECT_NE(page.find(svg.substr(begin, at - begin)), page.npos) << panels;
  }
  EXPECT_EQ(panels, 1);
}

// A point (arc, IoU) lies where the axes' marks say: between the gridlines and labels next to it.
TEST(ArcCurves, PointsLieWhereTheAxesSay) {
  const TempFolder folder;
  write_results(folder.path(), {{"a", 1, {{"61", "0.2"}, {"91", "0.6"}, {"149", "1"}}}});
  const std::string svg = arc_svg(read_results(folder.path()));
  const auto label_x = [&](const std::string& label) {
    std::smatch found;
    EXPECT_TRUE(std::regex_search(svg, found, std::regex("x=\"([0-9.]+)\"[^>]*>" + label + "<")));
    return std::stod(found[1]);
  };
  const auto line_y = [&](const std::string& label) {  // the grid line is drawn just before its label
    std::smatch found;
    EXPECT_TRUE(
        std::regex_search(svg, found, std::regex("M[0-9.]+ ([0-9.]+)h[0-9.]+\"/><text[^>]*>" + label + "<")));
    return std::stod(found[1]);
  };
  std::smatch path;
  ASSERT_TRUE(std::regex_search(
      svg, path, std::regex("d=\"M([0-9.]+) ([0-9.]+)L([0-9.]+) ([0-9.]+)L([0-9.]+) ([0-9.]+)\"><title>a<")));
  const double degree = (label_x("90°") - label_x("60°")) / 30;
  constexpr double kDigit = 0.11;  // of the numbers in the file, twice rounded
  EXPECT_NEAR(std::stod(path[1]), label_x("60°") + 2.5 * degree, kDigit);  // the middle of 60 to 65
  EXPECT_NEAR(std::stod(path[3]), label_x("90°") + 2.5 * degree, kDigit);
  EXPECT_NEAR(std::stod(path[5]), label_x("150°") - 2.5 * degree, kDigit);
  EXPECT_NEAR(std::stod(path[2]), line_y("0.2"), kDigit);
  EXPECT_NEAR(std::stod(path[4]), line_y("0.6"), kDigit);
  EXPECT_NEAR(std::stod(path[6]), line_y("1.0"), kDigit);
}

TEST(ArcCurves, NamesCannotBreakThePicture) {
  const TempFolder folder;
  write_results(folder.path(), {{"<a>&", 1, {{"61", "0.2"}}}});
  const std::string svg = arc_svg(read_results(folder.path()));
  EXPECT_EQ(svg.find("<a>"), std::string::npos);
  EXPECT_NE(svg.find("<title>&lt;a&gt;&amp;</title>"), std::string::npos);
}

TEST(ArcCurves, OfEvaluationsWithoutArcsThereIsNothing) {
  const TempFolder folder;
  write_small_results(folder.path());
  write_file(folder.path() / "iou3d_by_arc.svg", "of another time");
  write_report(folder.path());
  EXPECT_FALSE(fs::exists(folder.path() / "iou3d_by_arc.svg"));
  EXPECT_EQ(read_text(folder.path() / "report.md").find("arc of views"), std::string::npos);
  EXPECT_EQ(read_text(folder.path() / "report.html").find("id=\"arcs\""), std::string::npos);
}

}  // namespace
}  // namespace uniquadric
