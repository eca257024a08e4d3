#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <regex>

#include "core/base/files.h"
#include "core/base/text.h"
#include "core/geometry/ellipsoid.h"
#include "evaluation/report/outline.h"
#include "evaluation/report/page.h"
#include "evaluation/report/report.h"
#include "tests/evaluation_report/browser.h"
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

Eigen::Vector3d vector(const json& v) {
  return Eigen::Vector3d(v[0], v[1], v[2]);
}

Pose pose_of(const json& pose) {
  return {Eigen::Quaterniond(pose[6], pose[3], pose[4], pose[5]).normalized(), vector(pose)};
}

using Outline = std::vector<Eigen::Vector2d>;

// The eye that the page says, as a camera of core's.
std::pair<Camera, Pose> eye_of(const json& painted) {
  const json& orbit = painted.at("orbit");
  const double yaw = orbit.at("yaw"), pitch = orbit.at("pitch"), distance = orbit.at("distance");
  const Eigen::Vector3d back(std::cos(pitch) * std::cos(yaw), std::cos(pitch) * std::sin(yaw),
                             std::sin(pitch));
  Eigen::Matrix3d world_from_eye;
  world_from_eye.col(2) = -back;
  world_from_eye.col(0) = (-back).cross(Eigen::Vector3d::UnitZ()).normalized();
  world_from_eye.col(1) = world_from_eye.col(2).cross(world_from_eye.col(0));
  const double width = painted.at("width"), height = painted.at("height");
  Camera camera;
  camera.fx = camera.fy = std::min(width, height) / 2 / std::tan(20 * std::numbers::pi / 180);
  camera.cx = width / 2, camera.cy = height / 2;
  return {camera, {Eigen::Quaterniond(world_from_eye), vector(orbit.at("target")) + distance * back}};
}

// The fabricated bodies (fabricated_results.cpp): object 1 is a mesh of four corners, estimated as a solid
// with three exponents about x; object 2 is a box.
Outline outline_of(const Camera& camera, const Pose& camera_from_object, const std::string& object,
                   bool truth, const Eigen::Vector3d& axes_m) {
  const bool first = object == "cuboid" || object == "skateboard";
  if (!first) return superellipsoid_outline(camera, camera_from_object, {axes_m, kBoxExponents, 2});
  if (!truth) return superellipsoid_outline(camera, camera_from_object, {axes_m, {1.5, 2, 1.2}, 0});
  Outline corners;
  for (const Eigen::Vector3d& corner :
       {Eigen::Vector3d(0.2, 0, 0), {-0.2, 0.15, 0}, {-0.2, -0.15, 0}, {0, 0, 0.1}})
    corners.push_back(*camera.project(camera_from_object * corner));
  return corners;
}

double reach(const Outline& outline, const Eigen::Vector2d& direction) {
  double most = -1e9;
  for (const Eigen::Vector2d& point : outline) most = std::max(most, direction.dot(point));
  return most;
}

// As far as each other in all directions, but for what the mesh of the page lacks.
void expect_alike(const json& points, const Outline& expected) {
  Outline painted;
  for (const json& point : points) painted.push_back(Eigen::Vector2d(point[0], point[1]));
  for (int i = 0; i < 36; ++i) {
    const Eigen::Vector2d direction(std::cos(i * std::numbers::pi / 18), std::sin(i * std::numbers::pi / 18));
    const double width = reach(expected, direction) + reach(expected, -direction);
    EXPECT_NEAR(reach(painted, direction), reach(expected, direction), 0.1 + 0.006 * width) << i;
  }
}

struct Expected {
  Outline in_space, in_film;
};

// Where the body of a page must be.
Expected expected_of(const json& painted, const json& body, const json& motion, const std::string& scene) {
  const auto index = painted.at("index").get<std::size_t>();
  const std::string label = body.at("label");
  for (const json& run : motion.at("runs")) {
    if (run.at("scene") != scene || (label.empty() ? run.at("seed") != 1 : run.at("variant") != label))
      continue;
    const json& truth = motion.at("truths")[run.at("truth").get<std::size_t>()];
    for (const json& track : (label.empty() ? truth : run).at("objects")) {
      if (track.at("object") != body.at("object")) continue;
      const auto [camera, eye] = eye_of(painted);
      const Pose object = pose_of(track.at("poses")[index]);
      const Eigen::Vector3d axes_m = vector(track.at("semi_axes_m")[0]);
      const double scale = painted.at("film_width").get<double>() / 640;
      Camera film;  // pixels' borders, not centres, lie at whole numbers of the page's
      film.fx = 525 * scale, film.fy = 520 * scale, film.cx = 321 * scale, film.cy = 238.5 * scale;
      const Pose film_eye = pose_of(truth.at("camera")[index]);
      return {outline_of(camera, eye.inverse() * object, track["object"], label.empty(), axes_m),
              outline_of(film, film_eye.inverse() * object, track["object"], label.empty(), axes_m)};
    }
  }
  return {};
}

// All that the views show is where it belongs; the number of bodies that were compared in space.
int expect_painted(const json& painted, const json& motion, const std::string& scene) {
  int compared = 0;
  for (const json& body : painted.at("bodies")) {
    const Outline expected = expected_of(painted, body, motion, scene).in_space;
    if (expected.empty()) continue;
    expect_alike(body.at("outline"), expected);
    ++compared;
  }
  for (const json& body : painted.at("in_film"))
    if (const Outline expected = expected_of(painted, body, motion, scene).in_film; !expected.empty())
      expect_alike(body.at("outline"), expected);
  return compared;
}

// What WebGL fills is what core's outline encloses: a box is drawn as a box.
void expect_solid_pixels(const json& space, const json& motion) {
  ASSERT_FALSE(space.at("solids").empty());
  for (const json& solid : space.at("solids")) {
    const Outline expected = expected_of(space.at("late"), solid, motion, "cube_cuboid").in_space;
    if (expected.empty()) continue;  // a track of no object
    std::vector<cv::Point2f> polygon;
    for (const Eigen::Vector2d& p : expected)
      polygon.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
    const double area = cv::contourArea(polygon);
    const json& pixels = solid.at("pixels");
    EXPECT_NEAR(pixels.at("count"), area, 0.05 * area + 40) << solid;
    EXPECT_NEAR(pixels.at("right"), reach(expected, Eigen::Vector2d::UnitX()), 2) << solid;
    EXPECT_NEAR(pixels.at("left"), -reach(expected, -Eigen::Vector2d::UnitX()), 2) << solid;
    EXPECT_NEAR(pixels.at("bottom"), reach(expected, Eigen::Vector2d::UnitY()), 2) << solid;
    EXPECT_NEAR(pixels.at("top"), -reach(expected, -Eigen::Vector2d::UnitY()), 2) << solid;
  }
}

Eigen::Vector2d middle_of(const json& body) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const json& point : body.at("outline")) sum += Eigen::Vector2d(point[0], point[1]);
  return sum / static_cast<double>(body.at("outline").size());
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

void expect_slider_moves_ellipsoids(const json& space, const json& motion) {
  const json &early = space.at("early"), &late = space.at("late");
  EXPECT_EQ(early.at("index"), 5);
  EXPECT_EQ(late.at("index"), 125);
  EXPECT_NE(early.at("picture"), late.at("picture"));
  EXPECT_NE(early.at("figures"), late.at("figures"));
  EXPECT_NE(early.at("film"), late.at("film"));
  EXPECT_EQ(early.at("frame"), "frame 0");  // of every tenth that is kept, the nearest
  EXPECT_EQ(late.at("frame"), "frame 120");
  EXPECT_EQ(early.at("in_film").size(), 5u);
  EXPECT_NEAR(space.at("mark_s"), 125 / 30., 1e-6);  // the mark in the plots went along
  // Two true bodies and two estimates; from frame 120 the first is lost.
  EXPECT_EQ(early.at("bodies").size(), 4u + 1u);  // and the stray track, in frames 0 to 9
  EXPECT_EQ(expect_painted(early, motion, "cube_cuboid"), 4);
  EXPECT_EQ(expect_painted(late, motion, "cube_cuboid"), 3);
  EXPECT_EQ(expect_painted(space.at("both"), motion, "cube_cuboid"), 4);
  EXPECT_EQ(expect_painted(space.at("dragged"), motion, "cube_cuboid"), 4);
  for (const char* painted : {"start", "early", "late"})  // all in the picture
    for (const json& body : space[painted].at("bodies")) {
      const Eigen::Vector2d middle = middle_of(body);
      EXPECT_GT(middle.minCoeff(), 0);
      EXPECT_LT(middle.x(), space[painted].at("width"));
      EXPECT_LT(middle.y(), space[painted].at("height"));
    }
}

void expect_turns_zooms_follows_and_plays(const json& space) {
  const json &before = space.at("before_drag").at("orbit"), &dragged = space.at("dragged").at("orbit");
  EXPECT_LT(dragged.at("yaw"), before.at("yaw"));
  EXPECT_GT(dragged.at("pitch"), before.at("pitch"));
  EXPECT_EQ(dragged.at("distance"), before.at("distance"));
  const json &wheeled = space.at("wheeled").at("orbit"), &pinched = space.at("pinched").at("orbit");
  EXPECT_LT(wheeled.at("distance"), dragged.at("distance"));
  EXPECT_EQ(space["wheeled"].at("stays"), true);
  // It lies near the depth that the zoom is about, and pointers have whole pixels.
  const json &aim = space["wheeled"].at("aim"), &aimed = space["wheeled"].at("aimed");
  EXPECT_NEAR(aimed.at("x").get<double>(), aim.at("x").get<double>(), 8);
  EXPECT_NEAR(aimed.at("y").get<double>(), aim.at("y").get<double>(), 8);
  EXPECT_NEAR(pinched.at("distance").get<double>(), wheeled.at("distance").get<double>() / 2, 1e-9);
  for (const json& body : space.at("followed").at("bodies"))
    if (body.at("object") == "cube" && body.at("label") == "") {
      EXPECT_NEAR(middle_of(body).x(), space["followed"].at("width").get<double>() / 2, 30);
      EXPECT_NEAR(middle_of(body).y(), space["followed"].at("height").get<double>() / 2, 30);
    }
  EXPECT_GT(space.at("played"), 0);
  EXPECT_LT(space.at("played"), 149);  // it did not run to the end at once
  EXPECT_EQ(space.at("paused"), space.at("played"));
  EXPECT_EQ(space.at("pointed"), 70);
  EXPECT_EQ(space.at("stepped"), 71);
  EXPECT_EQ(space.at("address"), "#scene=cube_cuboid&object=cuboid&t=2.37&show=single_frame_obb%2Crotbbox");
  EXPECT_EQ(
      space.at("linked"),
      json({{"scene", "skateboard_ball"}, {"object", "ball"}, {"index", 60}, {"variants", {"rotbbox"}}}));
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
  expect_variants_side_by_side(seen.at("ablation"));
  expect_axes_with_marks(seen);
  expect_slider_moves_ellipsoids(seen.at("space"),
                                 json::parse(page_motion(read_results(folder_.path()), {})));
  expect_solid_pixels(seen.at("space"), json::parse(page_motion(read_results(folder_.path()), {})));
  expect_turns_zooms_follows_and_plays(seen.at("space"));
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
