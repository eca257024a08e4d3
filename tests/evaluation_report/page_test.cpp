#include "evaluation/report/page.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <regex>
#include <set>

#include "core/base/files.h"
#include "evaluation/report/page_assets.h"
#include "evaluation/report/report.h"
#include "tests/evaluation_report/fabricated_results.h"
#include "tests/evaluation_report/small_results.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

// What stands between an opening tag and the next closing script tag: as a browser cuts it.
json script_json(const std::string& html, const std::string& id) {
  const std::string open = "<script type=\"application/json\" id=\"" + id + "\">";
  const std::size_t begin = html.find(open);
  EXPECT_NE(begin, std::string::npos);
  const std::size_t end = html.find("</script>", begin);
  return json::parse(html.substr(begin + open.size(), end - begin - open.size()));
}

std::string decode_base64(const std::string& text) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned bits = 0, count = 0;
  for (const char c : text) {
    if (c == '=') break;
    bits = bits << 6 | static_cast<unsigned>(digits.find(c));
    count += 6;
    if (count >= 8) bytes += static_cast<char>(bits >> (count -= 8) & 0xff);
  }
  return bytes;
}

TEST(Page, SameBytesForTheSameResults) {
  const TempFolder folder;
  fabricate_results(folder.path(), {.frames = 20});
  std::vector<std::string> first;
  for (const char* file : {"report.html", "report.md", "scores.csv"}) {
    write_report(folder.path());
    first.push_back(read_text(folder.path() / file));
    write_report(folder.path());
    EXPECT_EQ(read_text(folder.path() / file), first.back()) << file;
  }
  // And in another place.
  const TempFolder other;
  fs::copy(folder.path(), other.path() / "moved", fs::copy_options::recursive);
  write_report(other.path() / "moved");
  EXPECT_EQ(read_text(other.path() / "moved/report.html"), first[0]);
}

TEST(Page, LoadsNothingFromOutside) {
  const TempFolder folder;
  fabricate_results(folder.path(), {.frames = 20});
  write_report(folder.path());
  std::string html = read_text(folder.path() / "report.html");
  const std::string policy = "content=\"default-src 'none'; img-src data:; style-src 'unsafe-inline'";
  EXPECT_NE(html.find(policy), std::string::npos);
  for (const char* library : {"chart.min.js", "three.min.js"}) {  // they name addresses
    const std::string script(page_asset(library));
    const std::size_t at = html.find(script);
    ASSERT_NE(at, std::string::npos);
    html.erase(at, script.size());
  }
  html =
      std::regex_replace(html, std::regex("xmlns=\"http://www.w3.org/2000/svg\""), "");  // a name, no address
  EXPECT_EQ(html.find("http://"), std::string::npos);
  EXPECT_EQ(html.find("https://"), std::string::npos);
  EXPECT_FALSE(std::regex_search(html, std::regex("<(script|img|iframe)[^>]* src=|@import|url\\(")));
}

TEST(Page, EmbeddedDataReadsBack) {
  const TempFolder folder;
  fabricate_results(folder.path(), {.frames = 30});
  const Results results = read_results(folder.path());
  write_report(folder.path());
  const json data = script_json(read_text(folder.path() / "report.html"), "data");
  EXPECT_EQ(data.at("name"), "fabricated");
  EXPECT_EQ(data.at("command"), "uniquadric bench configs/bench/fabricated.yaml out");
  EXPECT_EQ(data.at("program"), "uniquadric 0.1.0, commit 0123abcd, changed since");
  EXPECT_EQ(data.at("inputs"), json({"bench fabricated 00112233", "scene cube_cuboid 44556677"}));
  ASSERT_EQ(data.at("cells").size(), 8u);
  constexpr double kFourDigits = 5e-4;  // relative: PageOptions::series_digits
  int values = 0;
  for (std::size_t c = 0; c < 7; ++c) {  // the eighth failed
    const json& cell = data["cells"][c];
    for (std::size_t s = 0; s < 2; ++s) {
      const ObjectSeries& series = results.cells[c].evaluation->series[s];
      const auto& expected = series.columns.at("ape_translation_m");
      const json& columns = cell.at("series")[s].at("columns").at("ape_translation_m");
      ASSERT_EQ(columns.size(), 30u);  // nothing thinned out
      for (std::size_t i = 0; i < expected.size(); ++i, ++values)
        EXPECT_NEAR(columns[i].get<double>(), *expected[i], kFourDigits * *expected[i]);
    }
  }
  EXPECT_EQ(values, 7 * 2 * 30);
  EXPECT_EQ(data["cells"][7].at("status"), "failed");
}

TEST(Page, TextOfTheResultsCannotLeaveItsScript) {
  const TempFolder folder;
  write_small_results(folder.path());
  const std::string nasty = "</script><script>alert(1)</script><!-- {{data}} \xff";
  write_file(folder.path() / "cells.csv",
             "scene,variant,seed,status,folder,message\ns,a,1,failed,x," + nasty + "\n");
  write_file(folder.path() / "bench.yaml", "name: \"<b>{{style}}</b>\"\n");
  write_report(folder.path());
  const std::string html = read_text(folder.path() / "report.html");
  EXPECT_EQ(html.find("alert(1)</script>"), std::string::npos);
  EXPECT_NE(html.find("<p class=\"kicker\">&lt;b&gt;{{style}}&lt;/b&gt;</p>"), std::string::npos);
  const std::string message = script_json(html, "data").at("cells")[0].at("message");
  EXPECT_EQ(message,
            "</script><script>alert(1)</script><!-- {{data}} \xef\xbf\xbd");  // U+FFFD for the stray byte
}

TEST(Page, PicturesAreTheFilesAndFitTheirBudget) {
  const TempFolder folder;
  fabricate_results(folder.path(), {.frames = 10, .overlays = 5});
  write_file(folder.path() / "cells/cube_cuboid/single_frame_obb/seed_1/overlays/sheet.jpg", "no frame");
  const Results results = read_results(folder.path());
  const json all = json::parse(page_images(results, {}));
  ASSERT_EQ(all.size(), 4u);  // the first good seed of each scene and variant
  std::size_t bytes = 0;
  for (const json& gallery : all) {
    ASSERT_EQ(gallery.at("frames").size(), 5u);
    for (const json& frame : gallery["frames"]) {
      const std::string name = cv::format("%06d.jpg", frame.at("frame").get<int>());
      const fs::path file = folder.path() / "cells" / gallery["scene"].get<std::string>() /
                            gallery["variant"].get<std::string>() / "seed_1/overlays" / name;
      const std::string picture = decode_base64(frame.at("jpeg"));
      EXPECT_EQ(picture, read_text(file));
      bytes += picture.size();
    }
  }
  const json half = json::parse(page_images(results, {.image_bytes = bytes / 2}));
  for (const json& gallery : half) {
    EXPECT_EQ(gallery.at("frames").size(), 2u);  // two of five are under one half
    EXPECT_EQ(gallery.at("frames")[0].at("frame"), 0);
    EXPECT_EQ(gallery.at("frames")[1].at("frame"), 9);
    EXPECT_EQ(gallery.at("available"), 5);
  }
  EXPECT_EQ(json::parse(page_images(results, {.image_bytes = 10}))[0].at("frames").size(), 0u);
  // Of four runs of five alike frames two keep one.
  const json few = json::parse(page_images(results, {.image_bytes = bytes / 20 * 5 / 2}));
  std::vector<std::size_t> counts;
  for (const json& gallery : few) counts.push_back(gallery.at("frames").size());
  EXPECT_EQ(counts, (std::vector<std::size_t>{1, 0, 0, 1}));
  EXPECT_EQ(few[0]["frames"][0].at("frame"), all[0]["frames"][2].at("frame"));  // the middle one
}

// The fabricated poses are known (fabricated_results.h).
TEST(Page, MotionIsThinnedAndKeepsTheTruthOnce) {
  const TempFolder folder;
  fabricate_results(folder.path(), {.frames = 150, .overlays = 0});
  const json motion = json::parse(page_motion(read_results(folder.path()), {.motion_frames = 150}));
  ASSERT_EQ(motion.at("runs").size(), 4u);    // the first good seed of each scene and variant
  ASSERT_EQ(motion.at("truths").size(), 2u);  // variants share it; scenes differ in their objects' names
  constexpr double kRounding = 0.5e-3 + 1e-12;
  int checked = 0;
  for (const json& run : motion["runs"]) {
    const double error_m = run.at("variant") == "single_frame_obb" ? 0.5 : 0.01;  // of seed 1
    EXPECT_EQ(run.at("seed"), 1);
    const json& truth = motion["truths"][run.at("truth").get<std::size_t>()];
    EXPECT_EQ(truth.at("stamps_ns")[149], 1'000'000'000 + 149 * 33'333'333LL);
    const json &lost = run.at("objects")[0], &kept = run["objects"][1];
    for (std::size_t k = 0; k < 150; ++k, ++checked) {
      EXPECT_EQ(lost.at("poses")[k].is_null(), k >= 120 && k < 130) << k;
      const json &a = truth.at("objects")[1].at("poses")[k], &b = kept.at("poses")[k];
      EXPECT_NEAR(a[0], 0.01 * static_cast<double>(k) - 1, kRounding);
      EXPECT_NEAR(b[1], 1.6 + error_m, kRounding);
      EXPECT_NEAR(b[5], std::sin(0.005 * static_cast<double>(k)), kRounding);
      EXPECT_EQ(run.at("unmatched")[0].at("poses")[k].is_null(), k >= 10) << k;
    }
    EXPECT_EQ(kept.at("semi_axes_m").size(), 1u);  // constant
    EXPECT_NEAR(kept["semi_axes_m"][0][0], 0.2 + error_m, kRounding);
    EXPECT_EQ(run["unmatched"][0].at("object"), "track 7");
  }
  EXPECT_EQ(checked, 4 * 150);
  EXPECT_EQ(motion["runs"][0]["objects"][1].at("object"), "cube");
  const json thin = json::parse(page_motion(read_results(folder.path()), {.motion_frames = 3}));
  EXPECT_EQ(thin["truths"][0]["stamps_ns"],
            json({1'000'000'000, 1'000'000'000 + 75 * 33'333'333LL, 1'000'000'000 + 149 * 33'333'333LL}));
  EXPECT_EQ(thin["runs"][0]["camera"].size(), 3u);
}

// Two scenes, two variants, two seeds, of which one failed: seven runs with two objects.
TEST(Page, ManyRunsAreThinned) {
  const TempFolder folder;
  fabricate_results(folder.path(), {.frames = 160, .overlays = 0});
  const Results results = read_results(folder.path());
  const auto plotted = [&](std::size_t values) {
    std::set<std::size_t> frames;
    int runs = 0;
    const json data = json::parse(page_data(results, summarize(results), {}, {.series_values = values}));
    for (const json& cell : data.at("cells")) {
      if (!cell.contains("series")) continue;
      ++runs;
      for (const json& series : cell.at("series")) {
        frames.insert(series.at("frames").size());
        EXPECT_EQ(series.at("columns").at("iou3d").size(), series["stamps_ns"].size());
      }
    }
    return std::pair(runs, frames);
  };
  const std::size_t all = 7 * 2 * 160 * 14;  // columns plotted
  EXPECT_EQ(plotted(all), std::pair(7, std::set<std::size_t>{160}));
  EXPECT_EQ(plotted(all / 2), std::pair(7, std::set<std::size_t>{80}));
  EXPECT_EQ(plotted(all / 10), std::pair(4, std::set<std::size_t>{20}));  // the first seeds
  EXPECT_EQ(plotted(1), std::pair(1, std::set<std::size_t>{20}));
  const auto motion = [&](std::size_t poses) {
    const json shown = json::parse(page_motion(results, {.motion_poses = poses}));
    return std::pair(shown.at("runs").size(), shown["runs"][0].at("camera").size());
  };
  EXPECT_EQ(motion(40'000), std::pair(std::size_t{4}, std::size_t{150}));
  EXPECT_EQ(motion(4 * 4 * 50), std::pair(std::size_t{4}, std::size_t{50}));
  EXPECT_EQ(motion(2 * 4 * 20), std::pair(std::size_t{2}, std::size_t{20}));
}

TEST(Page, SaysHowWorldsWereAligned) {
  const TempFolder folder;
  fabricate_results(folder.path(), {.frames = 5});
  write_report(folder.path());
  const json data = script_json(read_text(folder.path() / "report.html"), "data");
  EXPECT_EQ(data["alignments"], json::array({"single_frame_obb: poses", "rotbbox: poses"}));
  EXPECT_NE(read_text(folder.path() / "report.md")
                .find("alignment of the estimates' worlds: single_frame_obb: poses, rotbbox: poses\n"),
            std::string::npos);
}

TEST(Page, EvenlySpacedKeepsBothEnds) {
  EXPECT_EQ(evenly_spaced(10, 4), (std::vector<std::size_t>{0, 3, 6, 9}));
  EXPECT_EQ(evenly_spaced(3, 3), (std::vector<std::size_t>{0, 1, 2}));
  EXPECT_EQ(evenly_spaced(5, 1), (std::vector<std::size_t>{0}));
  EXPECT_TRUE(evenly_spaced(5, 0).empty());
}

TEST(Page, MarkdownHasThePapersTwoSystems) {
  const TempFolder folder;
  fabricate_results(folder.path(), {.frames = 3, .overlays = 0});
  write_report(folder.path());
  const std::string text = read_text(folder.path() / "report.md");
  EXPECT_NE(
      text.find("| cube_cuboid | cube | *paper, single-frame baseline* |  | *0.440* | *2.260* | *0.411* "
                "| *1.510* |"),
      std::string::npos);
  EXPECT_NE(
      text.find("| cube_cuboid | cube | *paper, UniQuadric* |  | *0.130* | *0.247* | *0.103* | *0.016* |"),
      std::string::npos);
}

TEST(Page, MarkdownListsTheFailure) {
  const TempFolder folder;
  write_small_results(folder.path());
  write_report(folder.path());
  const std::string text = read_text(folder.path() / "report.md");
  EXPECT_NE(text.find("| s | cube | a | 1/1 | 0.100 |"), std::string::npos);
  EXPECT_EQ(text.find("*paper"), std::string::npos);  // the scene is not the paper's
  EXPECT_NE(text.find("| s | b | 1 | estimate: no depth, and"), std::string::npos);
}

}  // namespace
}  // namespace uniquadric
