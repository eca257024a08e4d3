#include "evaluation/metric.h"

#include <gtest/gtest.h>

#include <array>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>

#include "core/base/error.h"

namespace uniquadric {
namespace {
using nlohmann::json;

struct Answers {
  int exit_code;
  std::vector<json> lines;
};

Answers ask(const std::string& kind, const std::string& lines, const MetricOptions& options = {}) {
  std::istringstream in(lines);
  std::ostringstream out;
  Answers answers{run_metric(kind, options, in, out), {}};
  std::istringstream result(out.str());
  for (std::string line; std::getline(result, line);) answers.lines.push_back(json::parse(line));
  return answers;
}

std::string ellipsoid(const std::string& c, const std::string& a, const std::string& q = "[0,0,0,1]") {
  return R"({"c":)" + c + R"(,"q":)" + q + R"(,"a":)" + a + "}";
}

std::string pair(const std::string& gt, const std::string& est) {
  return R"({"id":7,"gt":)" + gt + R"(,"est":)" + est + "}\n";
}

const std::string kCamera =
    R"("camera":{"K":[500,0,320,0,500,240,0,0,1],"width":640,"height":480,"t_wc":[0,0,0],"q_wc":[0,0,0,1]})";

}  // namespace

TEST(Metric, Iou3dExactAndMonteCarlo) {
  const std::string nested = pair(ellipsoid("[1,2,3]", "[1,1,1]"), ellipsoid("[1,2,3]", "[0.5,0.5,0.5]"));
  const Answers exact = ask("iou3d", nested);
  EXPECT_EQ(exact.exit_code, 0);
  ASSERT_EQ(exact.lines.size(), 1u);
  EXPECT_EQ(exact.lines[0]["id"], 7);
  EXPECT_EQ(exact.lines[0]["method"], "exact");
  EXPECT_EQ(exact.lines[0]["stderr"], 0);
  EXPECT_NEAR(exact.lines[0]["iou"], 0.125, 1e-9);
  const json sampled = ask("iou3d", nested, {"monte-carlo", 10'000, 3}).lines.at(0);
  EXPECT_NEAR(sampled["iou"], 0.125, 5 * sampled["stderr"].get<double>());
}

TEST(Metric, BadLinesAreAnsweredAndTheOthersGoOn) {
  const std::string good = ellipsoid("[0,0,0]", "[1,1,1]");
  const std::vector<std::string> bad = {pair(good, ellipsoid("[0,0,0]", "[1,0,1]")),
                                        pair(good, ellipsoid("[0,0,0]", "[1,-1,1]")),
                                        pair(good, ellipsoid("[0,NaN,0]", "[1,1,1]")),
                                        pair(ellipsoid("[0,0,0]", "[Infinity,1,1]"), good),
                                        pair(good, ellipsoid("[0,0]", "[1,1,1]")),
                                        pair(good, ellipsoid("[0,0,0]", "[1,1,1]", "[0,0,0,1.01]")),
                                        pair(good, ellipsoid("[0,0,0]", "[1,1,1]", "[0,0,0,0]")),
                                        R"({"id":7,"gt":3,"est":4})"
                                        "\n",
                                        R"({"id":7})"
                                        "\n"};
  std::string lines = "not json\n \n";  // the blank line has a number and no answer
  for (const auto& line : bad) lines += line + pair(good, good);
  const Answers answers = ask("iou3d", lines);
  EXPECT_EQ(answers.exit_code, 2);
  ASSERT_EQ(answers.lines.size(), 1 + 2 * bad.size());
  EXPECT_TRUE(answers.lines[0]["id"].is_null());
  EXPECT_EQ(answers.lines[0]["line"], 1);
  for (std::size_t i = 0; i < bad.size(); ++i) {
    const json& answer = answers.lines[1 + 2 * i];
    EXPECT_EQ(answer["id"], 7) << bad[i];
    EXPECT_TRUE(answer.contains("error") && !answer.contains("iou")) << bad[i];
    EXPECT_EQ(answer["line"], 3 + 2 * i) << bad[i];
    EXPECT_EQ(answers.lines[2 + 2 * i]["iou"], 1) << bad[i];
    EXPECT_FALSE(answers.lines[2 + 2 * i].contains("line"));
  }
}

TEST(Metric, ProjectHasItsOutcomes) {
  const auto project = [](const std::string& c, const std::string& a) {
    return ask("project", R"({"id":"x",)" + kCamera + R"(,"gt":)" + ellipsoid(c, a) + "}").lines.at(0);
  };
  const json ok = project("[0,0,5]", "[1,1,1]");
  EXPECT_EQ(ok["id"], "x");
  EXPECT_EQ(ok["status"], "ok");
  // outline of a ball on the axis: tan of its half angle
  EXPECT_NEAR(ok["semi_major"], 500 / std::sqrt(24), 1e-10);
  EXPECT_NEAR(ok["centre"][0], 320, 1e-10);
  int others = 0;
  for (const auto& [status, c] :
       {std::pair{"behind", "[0,0,-5]"}, {"not_an_ellipse", "[3,0,0.5]"}, {"inside", "[0,0,0.5]"}}) {
    const json answer = project(c, "[1,1,1]");
    EXPECT_EQ(answer["status"], status);
    EXPECT_EQ(answer.size(), 2u) << "no numbers: " << answer;
    ++others;
  }
  EXPECT_EQ(others, 3);
}

TEST(Metric, Iou2dIsNullWithoutAnOutline) {
  const auto overlap = [](const std::string& gt, const std::string& est) {
    return ask("iou2d", R"({"id":1,)" + kCamera + R"(,"gt":)" + gt + R"(,"est":)" + est + "}").lines.at(0);
  };
  const std::string ball = ellipsoid("[0,0,5]", "[1,1,1]");
  const json same = overlap(ball, ball);
  for (const char* key : {"rect_iou", "ellipse_iou", "aabb_iou", "rect_iou_clipped"})
    EXPECT_EQ(same[key], 1) << key;
  const json behind = overlap(ball, ellipsoid("[0,0,-5]", "[1,1,1]"));
  EXPECT_EQ(behind["status"], "behind");
  for (const char* key : {"rect_iou", "ellipse_iou", "aabb_iou", "rect_iou_clipped"})
    EXPECT_TRUE(behind[key].is_null()) << key;
  const std::string off = ellipsoid("[50,0,5]", "[1,1,1]");
  EXPECT_EQ(overlap(off, off)["rect_iou"], 1);
  EXPECT_TRUE(overlap(off, off)["rect_iou_clipped"].is_null());
}

TEST(Metric, PoseUndoesRenamedAxes) {
  // a quarter turn about z with x and y exchanged is the same body
  const json answer =
      ask("pose",
          pair(ellipsoid("[0,0,0]", "[0.3,0.2,0.1]"),
               ellipsoid("[3,4,0]", "[0.2,0.3,0.1]", "[0,0,0.70710678118654757,0.70710678118654757]")))
          .lines.at(0);
  EXPECT_NEAR(answer["translation_error_m"], 5, 1e-12);
  EXPECT_NEAR(answer["d_shape_m"], 5, 1e-12);
  EXPECT_NEAR(answer["rotation_error_naive_rad"], std::numbers::pi / 2, 1e-12);
  EXPECT_NEAR(answer["rotation_error_symmetric_rad"], 0, 1e-12);
  for (const json& error : answer["axis_errors_m"]) EXPECT_EQ(error, 0);
  const std::string ball = ellipsoid("[0,0,0]", "[1,1,1]");
  EXPECT_TRUE(ask("pose", pair(ball, ball)).lines.at(0)["rotation_error_symmetric_rad"].is_null());
}

TEST(Metric, IdsAreTextNumbersOrNullAndNestingEnds) {
  const std::string good = ellipsoid("[0,0,0]", "[1,1,1]");
  const auto deep = [](int depth) { return std::string(depth, '[') + std::string(depth, ']'); };
  const std::string rest = R"(,"gt":)" + good + R"(,"est":)" + good + "}\n";
  int cases = 0;
  for (const std::string& id : {deep(120'000), deep(1), std::string("{}"), std::string("true")}) {
    const Answers answers = ask("iou3d", R"({"id":)" + id + rest + pair(good, good));
    EXPECT_EQ(answers.exit_code, 2);
    ASSERT_EQ(answers.lines.size(), 2u);
    EXPECT_TRUE(answers.lines[0].contains("error") && answers.lines[0]["id"].is_null());
    EXPECT_EQ(answers.lines[1]["iou"], 1);
    ++cases;
  }
  EXPECT_EQ(cases, 4);
  const Answers elsewhere = ask("iou3d", R"({"id":1,"note":)" + deep(120'000) + rest + pair(good, good));
  ASSERT_EQ(elsewhere.lines.size(), 2u);
  EXPECT_TRUE(elsewhere.lines[0].contains("error"));
  for (const char* id : {"\"x\"", "-3", "2.5", "null"})
    EXPECT_EQ(ask("iou3d", R"({"id":)" + std::string(id) + rest).lines.at(0)["id"].dump(), id);
}

// Ids that another program may take for one another, and keys of which some programs read the first and some
// the last.
TEST(Metric, IdsBeyondADoubleAndKeysThatStandTwiceAreNamed) {
  const std::string good = ellipsoid("[0,0,0]", "[1,1,1]");
  const std::string rest = R"(,"gt":)" + good + R"(,"est":)" + good;
  const auto error_of = [&](const std::string& line) {
    const Answers answers = ask("iou3d", line + "\n" + pair(good, good));
    EXPECT_EQ(answers.exit_code, 2) << line;
    EXPECT_EQ(answers.lines.at(1)["iou"], 1) << line;
    return answers.lines.at(0).value("error", "");
  };
  for (const char* id : {"9007199254740993", "-9007199254740993", "18446744073709551615", "1e20"})
    EXPECT_NE(error_of(R"({"id":)" + std::string(id) + rest + "}").find("is beyond 2^53"), std::string::npos)
        << id;
  EXPECT_EQ(error_of(R"({"id":1)" + rest + R"(,"gt":)" + good + "}"), "key \"gt\" stands twice");
  EXPECT_EQ(error_of(R"({"id":1,"id":2)" + rest + "}"), "key \"id\" stands twice");
  EXPECT_EQ(error_of(R"({"id":1,"note":{"a":[{"b":1,"b":NaN}]})" + rest + "}"), "key \"b\" stands twice");
  // the same key in two objects, here gt and est, is none that stands twice
  const std::string fine = R"({"id":9007199254740991)" + rest + "}";
  const Answers answers = ask("iou3d", fine);
  EXPECT_EQ(answers.exit_code, 0) << answers.lines.at(0);
  EXPECT_EQ(answers.lines.at(0)["id"].dump(), "9007199254740991");
}

TEST(Metric, LinesThatCannotBeReadKeepTheirIds) {
  const std::string good = ellipsoid("[0,0,0]", "[1,1,1]");
  const std::string rest = R"(,"gt":)" + good + R"(,"est":)" + good;
  const std::string huge = R"("gt":)" + ellipsoid("[0,1e400,0]", "[1,1,1]") + R"(,"est":)" + good;
  const std::array<std::array<std::string, 3>, 15> cases = {
      {{R"({"id":7,)" + huge + "}", "7", "gt.c holds a number that no double can"},
       {"{" + huge + R"(, "id" : "a\"b" })", R"("a\"b")", "gt.c holds a number that no double can"},
       {R"({"id":"x")" + rest + R"(,"gt":)" + good + "}", R"("x")", "key \"gt\" stands twice"},
       {R"({"n":{"b":1,"b":2},"id":-3.5)" + rest + "}", "-3.5", "key \"b\" stands twice"},
       {R"({"id":7)" + rest, "7", "is not valid JSON"},
       {R"({"gt":{"id":9},"x":"id","id":8,)", "8", "is not valid JSON"},
       {R"({"id":7,"note":)" + std::string(20, '[') + std::string(20, ']') + "}", "7",
        "is nested more than 8 levels deep"},
       {R"({"id":7)", "null", "is not valid JSON"},  // may be the first figure of more
       {R"({"id":"x)", "null", "is not valid JSON"},
       {R"({"id":7,"id":7)" + rest + "}", "null", "key \"id\" stands twice"},
       {R"({"id":1e400)" + rest + "}", "null", "id holds a number that no double can"},
       {R"({"id":[7],"x":)", "null", "is not valid JSON"},
       {R"({"x":{"id":7},)", "null", "is not valid JSON"},
       {R"({"id")", "null", "is not valid JSON"},
       {R"(["id",7])", "null", "expected a JSON object"}}};
  std::string lines;
  for (const auto& line : cases) lines += line[0] + "\n";
  const Answers answers = ask("iou3d", lines);
  EXPECT_EQ(answers.exit_code, 2);
  ASSERT_EQ(answers.lines.size(), cases.size());
  for (std::size_t i = 0; i < cases.size(); ++i) {
    EXPECT_EQ(answers.lines[i]["id"].dump(), cases[i][1]) << cases[i][0];
    EXPECT_EQ(answers.lines[i]["error"], cases[i][2]) << cases[i][0];
    EXPECT_EQ(answers.lines[i]["line"], i + 1);
  }
}

TEST(Metric, WhatIsNoNumberIsCalledSo) {
  const std::string good = ellipsoid("[0,0,0]", "[1,1,1]");
  const std::array<std::array<std::string, 2>, 6> cases = {
      {{R"(["0",0,0])", "est.c[0]: expected a number, found string \"0\""},
       {"[0,true,0]", "est.c[1]: expected a number, found boolean true"},
       {"[0,0,[0]]", "est.c[2]: expected a number, found array [0]"},
       {"[0,0,\"" + std::string(100, 'x') + "\"]", "est.c[2]: expected a number, found string"},
       {"[NaN,0,0]", "est.c[0] is not a finite number"},
       {"[0,0,-Infinity]", "est.c[2] is not a finite number"}}};
  for (const auto& [c, error] : cases)
    EXPECT_EQ(ask("iou3d", pair(good, ellipsoid(c, "[1,1,1]"))).lines.at(0)["error"], error);
}

TEST(Metric, ALineWithoutEndIsAnsweredAndTheNextGoesOn) {
  const std::string good = pair(ellipsoid("[1,2,3]", "[1,1,1]"), ellipsoid("[1,2,3]", "[1,1,1]"));
  const Answers answers = ask("iou3d", std::string(3 << 20, '[') + "\n" + good);
  EXPECT_EQ(answers.exit_code, 2);
  ASSERT_EQ(answers.lines.size(), 2u);
  EXPECT_EQ(answers.lines[0]["error"], "is longer than 1048576 bytes");
  EXPECT_EQ(answers.lines[1]["iou"], 1);
}

TEST(Metric, MagnitudesBeyondTheArithmeticAreNamed) {
  const std::string good = ellipsoid("[0,0,5]", "[1,1,1]");
  const std::vector<std::array<std::string, 3>> bodies = {{"[0,0,3e160]", "[1e150,1,1]", "gt.c[2]"},
                                                          {"[0,0,5]", "[1,1e200,1]", "gt.a[1]"},
                                                          {"[0,0,5]", "[1,1,1e-200]", "gt.a[2]"},
                                                          {"[-1e308,0,5]", "[1,1,1]", "gt.c[0]"},
                                                          {"[0,0,5]", "[1e12,1e-9,1e-9]", "gt.a: "}};
  int cases = 0;
  for (const char* kind : {"iou3d", "pose", "project", "iou2d"})
    for (const auto& [c, a, field] : bodies) {
      const std::string line =
          R"({"id":1,)" + kCamera + R"(,"gt":)" + ellipsoid(c, a) + R"(,"est":)" + good + "}";
      const Answers answers = ask(kind, line);
      EXPECT_EQ(answers.exit_code, 2);
      EXPECT_EQ(answers.lines.at(0).value("error", "").find(field), 0u) << answers.lines.at(0);
      ++cases;
    }
  EXPECT_EQ(cases, 20);
}

TEST(Metric, TheCornersOfTheAllowedRangeHaveNumbers) {
  int cases = 0, outlines = 0;
  for (const double size : {1e-9, 1.0, 1e12})
    for (const double ratio : {1.0, 1e-3, 1.01e-6})
      for (const double z : {1e-9, 10.0, 1e12}) {
        const double other = std::max(size * ratio, 1e-9);
        json line = json::parse("{" + kCamera + "}");
        line["gt"] = {{"c", {0.3, -0.2, z}}, {"q", {0.1, 0.7, -0.1, 0.7}}, {"a", {size, other, other}}};
        line["est"] = {{"c", {0.3, -0.2, z}}, {"q", {0.1, 0.7, -0.1, 0.7}}, {"a", {other, size, other}}};
        const json outline = ask("project", line.dump()).lines.at(0);
        if (outline["status"] == "ok") {
          EXPECT_GT(outline["semi_minor"], 0) << line;
          EXPECT_GE(outline["semi_major"], outline["semi_minor"]) << line;
          ++outlines;
        }
        EXPECT_TRUE(ask("pose", line.dump()).lines.at(0)["d_shape_m"].is_number()) << line;
        const json iou = ask("iou3d", line.dump()).lines.at(0)["iou"];
        EXPECT_TRUE(iou.is_number() && iou >= 0 && iou <= 1) << iou << line;
        const json overlap = ask("iou2d", line.dump()).lines.at(0);
        EXPECT_EQ(overlap["ellipse_iou"].is_number(), overlap["status"] == "ok") << overlap << line;
        ++cases;
      }
  EXPECT_EQ(cases, 27);
  EXPECT_GT(outlines, 5);
}

TEST(Metric, ThinOutlinesKeepTheirMinorAxis) {
  constexpr double kRelative = 1e-8;  // rounding over the ratio 1e-6; over its square it would be 1e-4
  // a blade whose third axis lies along the view: both half axes are f a / sqrt(z^2 - c^2)
  const std::string blade = ellipsoid("[0,0,5]", "[1,1e-6,1e-3]", "[0,0,0.28,0.96]");
  const json answer = ask("project", R"({"id":1,)" + kCamera + R"(,"gt":)" + blade + "}").lines.at(0);
  const double per_m = 500 / std::sqrt(25 - 1e-6);
  EXPECT_NEAR(answer["semi_major"].get<double>() / per_m, 1, kRelative);
  EXPECT_NEAR(answer["semi_minor"].get<double>() / (1e-6 * per_m), 1, kRelative);
}

TEST(Metric, FarFromTheOriginIsAsGoodAsNearIt) {
  // the same view from the origin and 1e7 m off, with a turned camera: positions are exact in both
  const auto view = [](double x, const char* kind) {
    const json q = {0.36, 0.48, 0.0, 0.8};
    json line = json::parse("{" + kCamera + "}");
    line["camera"]["q_wc"] = q;
    line["camera"]["t_wc"] = {x, -x, x};
    line["gt"] = {{"c", {x + 3.5, -x - 2.25, x + 2.5}}, {"q", {0, 0, 0, 1}}, {"a", {0.25, 0.5, 0.125}}};
    line["est"] = {{"c", {x + 3.5, -x - 2.25, x + 2.625}}, {"q", {0, 0, 0, 1}}, {"a", {0.25, 0.5, 0.125}}};
    return ask(kind, line.dump()).lines.at(0);
  };
  EXPECT_EQ(view(0, "project")["status"], "ok");
  EXPECT_EQ(view(1e7, "project"), view(0, "project"));
  EXPECT_EQ(view(1e7, "iou2d"), view(0, "iou2d"));
}

std::string shaped(const std::string& a, const std::string& shape) {
  return R"({"c":[1e4,0,0],"q":[0,0,0,1],"a":)" + a + R"(,"shape":)" + shape + "}";
}

TEST(Metric, Iou3dTakesShapes) {
  const std::string box = shaped("[1,1,1]", "\"box\""), ball = shaped("[1,1,1]", "\"ellipsoid\"");
  const std::string cylinder = shaped("[1,1,1]", R"({"superellipsoid":{"q":[2,1,1],"axis":"y"}})");
  const Answers answers =
      ask("iou3d", pair(box, shaped("[1,1,0.5]", "\"box\"")) + pair(box, ball) + pair(ball, box) +
                       pair(box, cylinder) +
                       pair(ball, shaped("[1,1,0.5]", R"({"superellipsoid":{"q":[2,2,2]}})")));
  ASSERT_EQ(answers.exit_code, 0);
  const auto expect = [&](std::size_t i, double iou, const char* method) {
    const json& line = answers.lines.at(i);
    const double error = line["stderr"];
    EXPECT_NEAR(line["iou"], iou, 4 * error + 1e-8) << i;
    EXPECT_LT(error, 0.002) << i;
    EXPECT_EQ(line["method"], method) << i;
  };
  using std::numbers::pi;
  expect(0, 0.5, "exact");
  expect(1, pi / 6, "sampled");
  expect(2, pi / 6, "sampled");
  expect(3, pi / 4, "sampled");
  expect(4, 0.5, "exact");
}

TEST(Metric, UnknownKeysAndShapesAreNamed) {
  const std::string ball = ellipsoid("[0,0,0]", "[1,1,1]");
  const auto error_of = [&](const std::string& kind, const std::string& line) {
    const Answers answers = ask(kind, line + "\n" + pair(ball, ball));
    EXPECT_EQ(answers.exit_code, 2) << line;
    return answers.lines.at(0).value("error", "");
  };
  const auto error_of_shape = [&](const std::string& shape) {
    return error_of("iou3d", pair(ball, shaped("[1,1,1]", shape)));
  };
  EXPECT_EQ(error_of("iou3d", R"({"gt":)" + ball + R"(,"est":)" + ball + R"(,"method":"exact"})"),
            "key 'method' is unknown, expected camera, est, gt, id");
  EXPECT_EQ(error_of("pose", R"({"gt":)" + ball + R"(,"est":{"c":[0,0,0],"q":[0,0,0,1],"a":[1,1,1],"r":1}})"),
            "est: key 'r' is unknown, expected a, c, q, shape");
  EXPECT_NE(error_of_shape("\"cube\"").find("est.shape: expected ellipsoid, box"), std::string::npos);
  EXPECT_NE(error_of_shape(R"({"superellipsoid":{"q":[2,2,0.9]}})").find("est.shape.superellipsoid.q[2]"),
            std::string::npos);
  EXPECT_NE(error_of_shape(R"({"superellipsoid":{"q":[2,2,2],"axis":"w"}})").find("axis: expected x, y or z"),
            std::string::npos);
}

TEST(Metric, RefusesUnknownKinds) {
  EXPECT_THROW(ask("iou4d", ""), InputError);
  EXPECT_THROW(ask("iou3d", "", {"guess", 1, 0}), InputError);
}

}  // namespace uniquadric
