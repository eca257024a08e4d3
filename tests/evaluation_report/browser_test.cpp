#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <regex>

#include "core/base/files.h"
#include "core/base/text.h"
#include "evaluation/report/page.h"
#include "evaluation/report/report.h"
#include "tests/evaluation_report/browser.h"
#include "tests/evaluation_report/browser_views.h"
#include "tests/evaluation_report/fabricated_results.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

// The text of <pre id="seen">, entities undone.
json seen_in(const std::string& document) {
  const std::string open = "<pre id=\"seen\">";
  const std::size_t begin = document.rfind(open);  // the script that made it names it too
  if (begin == document.npos) return nullptr;
  std::string text =
      document.substr(begin + open.size(), document.find("</pre>", begin) - begin - open.size());
  for (const auto& [entity, sign] : {std::pair{"&lt;", "<"}, {"&gt;", ">"}, {"&amp;", "&"}})
    text = std::regex_replace(text, std::regex(entity), sign);
  return json::parse(text);
}

// A report of fabricated results in Chromium, with browser_steps.js behind its scripts.
class Browser : public testing::Test {
 protected:
  void SetUp() override {
    chromium_ = find_chromium();
    if (!chromium_) GTEST_SKIP() << "no Chromium here";
    fabricate_results(folder_.path(), {.frames = 150});
    write_report(folder_.path());
  }

  // With "#tables" the steps end where the 3D view begins.
  json open(int width_px, int height_px, bool dark, const char* hash = "") {
    const std::string steps =
        read_text(fs::path(UNIQUADRIC_SOURCE_DIR) / "tests/evaluation_report/browser_steps.js");
    write_text(folder_.path() / "steps.html",
               read_text(folder_.path() / "report.html") + "<script>" + steps + "</script>");
    // Chromium's windows are no narrower than 500 px; a page within a page may be.
    write_text(folder_.path() / "frame.html",
               fmt::format("<meta name='color-scheme' content='light dark'><body style='margin: 0'>"
                           "<iframe src='steps.html{}' style='border: 0; width: {}px; height: {}px'></iframe>"
                           "<script>onmessage = (sent) => {{ const seen = document.createElement('pre'); "
                           "seen.id = 'seen'; seen.textContent = sent.data; document.body.append(seen); }};"
                           "</script>",
                           hash, width_px, height_px));
    const BrowserRun run =
        run_in_browser(*chromium_, folder_.path() / "frame.html", width_px, height_px, dark);
    EXPECT_EQ(run.exit_code, 0);
    for (const std::string& line : run.console) ADD_FAILURE() << line;
    return seen_in(run.document);
  }

  TempFolder folder_;
  std::optional<fs::path> chromium_;
};

std::vector<double> figures(const json& column) {
  std::vector<double> values;
  for (const json& text : column)
    if (const auto value = parse_double(text.get<std::string>())) values.push_back(*value);
  return values;
}

void expect_sorted(const json& table) {
  auto values = figures(table.at("original"));
  ASSERT_GE(values.size(), 12u);
  EXPECT_FALSE(std::is_sorted(values.begin(), values.end()));
  EXPECT_EQ(table["again"], table["original"]);
  std::sort(values.begin(), values.end());
  EXPECT_EQ(figures(table["best_first"]), values);
  std::reverse(values.begin(), values.end());
  EXPECT_EQ(figures(table["worst_first"]), values);
  const auto objects = table.at("objects").get<std::vector<std::string>>();
  EXPECT_TRUE(std::is_sorted(objects.begin(), objects.end()));
  EXPECT_EQ(objects.size(), table["original"].size());
}

// APE.t of the fabricated runs: 0.5 and 1 m against 0.01 and 0.02 m, on a logarithmic axis; one run of the
// last failed.
void expect_variants_side_by_side(const json& figures_seen) {
  ASSERT_EQ(figures_seen.size(), 6u);  // two objects and the camera of two scenes
  const json &coarse = figures_seen[0][0], &fine = figures_seen[0][1];
  EXPECT_EQ(coarse.at("title"), "single_frame_obb: mean 0.750 ± 3.2 (95 %) of 2 runs");  // 12.706 * 0.25
  EXPECT_EQ(fine.at("title"), "rotbbox: mean 0.0150 ± 0.064 (95 %) of 2 runs");
  const double decade = (coarse.at("mean").get<double>() - fine.at("mean").get<double>()) / std::log10(50);
  EXPECT_GT(decade, 10);  // per cent of the axis
  for (const json& row : {coarse, fine}) {
    const json& seeds = row.at("seeds");
    ASSERT_EQ(seeds.size(), 2u);
    EXPECT_NEAR(seeds[1].get<double>() - seeds[0].get<double>(), decade * std::log10(2), 0.01);
    EXPECT_NEAR(row.at("mean").get<double>() - seeds[0].get<double>(), decade * std::log10(1.5), 0.01);
    const double from = row.at("interval")[0], to = from + row.at("interval")[1].get<double>();
    EXPECT_LT(from, seeds[0]);
    EXPECT_GT(to, seeds[1]);
    EXPECT_LE(to, 100);
  }
  EXPECT_TRUE(figures_seen[3][1].at("interval").is_null());
  EXPECT_EQ(figures_seen[3][1].at("title"), "rotbbox: mean 0.0100 of one run");
}

// Two marks at least on every axis, and no bar of a share beyond 0 and 1.
void expect_axes_with_marks(const json& seen) {
  const json& axes = seen.at("axes");
  EXPECT_GT(axes.size(), 300u);
  for (const json& marks : axes) {
    ASSERT_GE(marks.size(), 2u) << axes;
    EXPECT_LT(marks.front(), marks.back());
    EXPECT_GE(marks.front(), -1e-6);  // per cent: rounding
    EXPECT_LE(marks.back(), 100 + 1e-6);
  }
  const json& clipped = seen.at("clipped");
  constexpr double kPercent = 0.01;
  EXPECT_NEAR(clipped.at("bars")[0][1], clipped.at("one"), kPercent);
  EXPECT_NEAR(clipped["bars"][1][0], clipped.at("zero"), kPercent);
  EXPECT_GT(clipped["bars"][0][0], clipped["bars"][1][0]);
}

// The last stage runs in every other frame, at 9 ms.
void expect_surfaces_and_times(const json& seen) {
  const auto head = seen.at("all_metrics")[0].get<std::vector<std::string>>();
  for (const char* name : {"surface error [m]", "surface error 90 % [m]", "surface seen"})
    EXPECT_NE(std::find(head.begin(), head.end(), name), head.end()) << name;
  const json& times = seen.at("times");
  ASSERT_EQ(times.size(), 1u + 4u);  // two scenes, two variants
  EXPECT_EQ(times[0], json({"variant", "whole [ms]", "features", "long_window"}));
  EXPECT_EQ(times[1], json({"single_frame_obbcube_cuboid", "12.5", "8.0", "4.5"}));
}

// Of the last object one of the two runs of rotbbox failed; all its figures are better elsewhere.
void expect_verdict(const json& seen) {
  const json& verdict = seen.at("verdict");
  EXPECT_EQ(verdict.at("head"), "single_frame_obb is level with rotbbox over 4 objects.");
  const std::string more = verdict.at("more");
  EXPECT_NE(more.find("better on skateboard and ball; worse on cuboid and cube."), more.npos) << more;
  EXPECT_EQ(verdict.at("there").at("better").size(), 2u);
  EXPECT_EQ(verdict.at("turned"), verdict["there"]);
  EXPECT_EQ(verdict.at("compared"),
            "2 variants on 2 scenes with 4 objects, 2 seeds: 1 of 8 runs have no result.");
  EXPECT_EQ(verdict.at("variants")[1], "Rotated rectangles, \"quoted\" & <kept>.");
  EXPECT_TRUE(verdict.at("film").get<std::string>().starts_with("cube_cuboid, single_frame_obb: frame "));
  const json& rows = seen.at("filtered");
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[0], json({"scene", "object", "variant", "runs", "against single_frame_obb", "APE.t [m]"}));
  EXPECT_EQ(rows[1][5], "0.7500.50 – 1.0");
  EXPECT_EQ(rows[2],
            json({"skateboard_ball", "ball", "rotbboxskateboard_ball / ball", "1/2", "lost", "0.0100−99 %"}));
}

// The fabricated errors are 0.02 of the baseline's.
void expect_ratios(const json& rows) {
  ASSERT_EQ(rows.size(), 1u + 4 * 2u);  // the head; of four objects the paper's and ours
  EXPECT_EQ(rows[0],
            json({"scene", "object", "system", "divided by", "runs", "APE.t", "APE.r", "RPE.t", "RPE.r"}));
  EXPECT_EQ(rows[1], json({"cube_cuboid", "cuboid", "paper, UniQuadric", "paper, single-frame baseline", "",
                           "0.126", "0.0603", "0.107", "0.0178"}));
  EXPECT_EQ(rows[2], json({"cube_cuboid", "cuboid", "rotbbox", "single_frame_obb", "2/2", "0.0200", "0.0200",
                           "0.0200", "0.0200"}));
}

// A circle for each run and each mean; every figure can be saved.
void expect_drawing_of_variants(const json& seen) {
  const std::string drawing = seen.at("drawing");
  EXPECT_TRUE(drawing.starts_with("<svg ") && drawing.ends_with("</svg>\n"));
  EXPECT_EQ(drawing.find("NaN"), drawing.npos);
  const std::regex circle("<circle ");
  EXPECT_EQ(std::distance(std::sregex_iterator(drawing.begin(), drawing.end(), circle), {}),
            seen.at("circles").get<int>());
  EXPECT_EQ(seen.at("buttons"), seen.at("figures"));
  EXPECT_GT(seen.at("figures").get<int>(), 0);
}

// Where paths are coloured by error the page says which error is red.
void expect_error_scale(const json& seen) {
  EXPECT_EQ(seen.at("shown"), seen.at("expected"));
  EXPECT_GT(seen.at("shown").get<int>(), 0);
  const std::string text = seen.at("text"), most = seen.at("most");
  EXPECT_NE(text.find(most + " m and more"), text.npos) << text;
  const std::string other = seen.at("other"), of_other = seen.at("of_other");
  EXPECT_NE(of_other.find("APE.t of " + other), of_other.npos) << of_other;
  EXPECT_EQ(seen.at("after"), "");
}

TEST_F(Browser, SaysWhyThereIsNo3DView) {
  const json whole = open(1280, 900, false, "#tables");
  EXPECT_EQ(whole.at("without_poses").at("note"), "");
  EXPECT_EQ(whole["without_poses"].at("view"), true);
  for (const auto& entry : fs::recursive_directory_iterator(folder_.path() / "cells"))
    if (entry.path().filename() == "poses.csv") fs::remove(entry.path());
  write_report(folder_.path());
  const json seen = open(1280, 900, false).at("without_poses");
  EXPECT_EQ(seen.at("section"), true);
  EXPECT_EQ(seen.at("view"), false);
  const std::string note = seen.at("note");
  EXPECT_NE(note.find("rotbbox, single_frame_obb"), note.npos) << note;
  EXPECT_NE(note.find("evaluation/poses.csv"), note.npos) << note;
}

TEST_F(Browser, TablesSortAndTheSliderMovesTheEllipsoids) {
  const json seen = open(1280, 900, false);
  ASSERT_TRUE(seen.is_object());
  expect_sorted(seen.at("table"));
  expect_surfaces_and_times(seen);
  expect_ratios(seen.at("ratios"));
  expect_verdict(seen);
  const std::string svg = seen.at("svg");
  EXPECT_TRUE(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"));
  EXPECT_NE(svg.find("APE &lt;of> a &amp; b"), svg.npos);
  EXPECT_NE(svg.find("rotbbox · seed 2"), svg.npos);
  EXPECT_EQ(svg.find("NaN"), svg.npos);
  expect_drawing_of_variants(seen.at("ablation_svg"));
  expect_error_scale(seen.at("ramps"));
  expect_variants_side_by_side(seen.at("ablation"));
  expect_axes_with_marks(seen);
  expect_slider_moves_ellipsoids(seen.at("space"),
                                 json::parse(page_motion(read_results(folder_.path()), {})));
  expect_solid_pixels(seen.at("space"), json::parse(page_motion(read_results(folder_.path()), {})));
  expect_turns_zooms_follows_and_plays(seen.at("space"));
  expect_links_show_their_variant(seen.at("space"));
}

TEST_F(Browser, FitsAPhoneInTheDark) {
  const json phone = open(375, 812, true), wide = open(1900, 1000, false);
  ASSERT_TRUE(phone.is_object());
  ASSERT_TRUE(wide.is_object());
  EXPECT_EQ(phone.at("page").at("width"), 375);
  EXPECT_LE(phone["page"].at("overflow"), 0);
  EXPECT_LE(wide.at("page").at("overflow"), 0);
  for (const json& seen : {phone, wide}) {
    EXPECT_EQ(seen.at("small").at("failures"), 4);  // of one run
    EXPECT_EQ(seen["small"].at("cut"), json::array());
    EXPECT_EQ(seen["small"].at("arcs"), 4);
    EXPECT_GT(seen["small"].at("letters"), 10);  // px: the height of a line of the smallest
  }
  EXPECT_GT(wide["page"].at("charts"), 4);
  EXPECT_EQ(phone["page"].at("background"), "rgb(20, 23, 26)");
  EXPECT_EQ(wide["page"].at("background"), "rgb(251, 250, 248)");
  const json motion = json::parse(page_motion(read_results(folder_.path()), {}));
  EXPECT_EQ(expect_painted(phone.at("space").at("early"), motion, "cube_cuboid"), 4);
}

TEST_F(Browser, NoColumnIsCutOffInWindowsFrom800Pixels) {
  for (const int width_px : {800, 1400, 1920}) {
    const json crowded = open(width_px, 900, false, "#tables").at("crowded");
    EXPECT_EQ(crowded.at("columns"), 14) << width_px;
    EXPECT_EQ(crowded.at("cut"), json::array()) << width_px;
  }
}

// Or the tests above would be glad of a page that does nothing.
TEST_F(Browser, ErrorsOfAPageAreSeen) {
  write_text(folder_.path() / "bad.html",
             "<script>console.error('loud')</script><script>nothing.here()</script>");
  const BrowserRun run = run_in_browser(*chromium_, folder_.path() / "bad.html", 800, 600, false);
  ASSERT_EQ(run.console.size(), 2u);
  EXPECT_NE(run.console[0].find("loud"), std::string::npos);
  EXPECT_NE(run.console[1].find("ReferenceError"), std::string::npos);
}

// Two scenes with two objects each are a few pages, not one object a page.
TEST_F(Browser, PrintsOnPagesOfA4) {
  const fs::path pdf = folder_.path() / "report.pdf";
  ASSERT_TRUE(print_in_browser(*chromium_, folder_.path() / "report.html", pdf));
  const std::string bytes = read_text(pdf);
  const std::regex box(R"(/MediaBox \[0 0 (\d+\.?\d*) (\d+\.?\d*)\])");
  int pages = 0;
  for (auto at = std::sregex_iterator(bytes.begin(), bytes.end(), box); at != std::sregex_iterator();
       ++at, ++pages) {
    EXPECT_NEAR(std::stod((*at)[1]), 210 / 25.4 * 72, 1);
    EXPECT_NEAR(std::stod((*at)[2]), 297 / 25.4 * 72, 1);
  }
  EXPECT_GE(pages, 3);
  EXPECT_LE(pages, 14);
}

}  // namespace
}  // namespace uniquadric
