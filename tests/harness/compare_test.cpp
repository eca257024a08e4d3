// `uniquadric compare` through the program: exit codes, forms of output, bad input.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/base/files.h"
#include "tests/evaluation/fabricated_scores.h"
#include "tests/harness/program.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
using nlohmann::json;

class CompareCommand : public testing::Test {
 protected:
  CompareCommand() { write("a.csv", fabricated_scores(kNoise, 1)); }
  std::string path(const std::string& name) const { return folder_.path() / name; }
  void write(const std::string& name, const std::vector<FabricatedScore>& scores) const {
    write_text(path(name), fabricated_csv(scores));
  }
  ProgramRun run(std::vector<std::string> options) const {
    options.insert(options.begin(), {"compare", path("a.csv"), path("b.csv")});
    return run_program(options);
  }
  // Of B against A.
  void expect_answer(const std::vector<FabricatedScore>& b, int exit_code, const std::string& what) const {
    write("b.csv", b);
    const ProgramRun result = run({});
    EXPECT_EQ(result.exit_code, exit_code) << result.out;
    EXPECT_EQ(result.err, "");
    EXPECT_NE(result.out.find(what), std::string::npos) << "wanted: " << what << "\ngot: " << result.out;
  }
  // Of the same scenes and seeds as A, with noise of its own.
  static std::vector<FabricatedScore> another_run() { return fabricated_scores(kNoise, 2); }

  static constexpr double kNoise = 0.03;

 private:
  TempFolder folder_;
};

TEST_F(CompareCommand, AnswersByItsExitCode) {
  auto b = fabricated_scores(kNoise, 1);
  expect_answer(b, 0, "pass: of 8 metrics 0 worse, 0 suspect, 0 better, 8 with no proven change");
  expect_answer(another_run(), 0, "pass: of 8 metrics 0 worse");
  b = another_run();
  scale(b, "d_shape_mean_m", 1.05);
  expect_answer(b, 1, "worse    d_shape_mean_m");
  b = another_run();
  scale(b, "d_shape_mean_m", 1.3, "s2");
  expect_answer(b, 1, "s2/cube +3");
  b = fabricated_scores(kNoise, 1);
  scale(b, "d_shape_mean_m", 1.008);
  expect_answer(b, 0, "suspect  d_shape_mean_m");
  b = fabricated_scores(kNoise, 1);
  b[3].failed = true;
  expect_answer(b, 1,
                "new failures (with a figure in A, failed in B):\n  s1/cube v seed 1: d_shape_mean_m\n");
  b = fabricated_scores(kNoise, 1);
  b.resize(b.size() - 16);
  expect_answer(b, 2, "missing in B:\n  s6 v seeds 7-8: the whole runs\n");
}

TEST_F(CompareCommand, JudgesPartsOfOtherMetricsOnlyIfAskedTo) {
  auto a = fabricated_scores(kNoise, 1);
  for (FabricatedScore score : fabricated_scores(kNoise, 1))
    if (score.metric == "d_shape_mean_m") {
      score.metric = "ape_translation_after_3s_rmse_m";
      a.push_back(score);
    }
  auto b = a;
  scale(b, "ape_translation_after_3s_rmse_m", 1.3);
  write("a.csv", a);
  expect_answer(b, 0, "pass: of 8 metrics 0 worse");
  EXPECT_EQ(run({"--metric", "ape_translation_after_3s_rmse_m"}).exit_code, 1);
}

// Of runs that all failed scores.csv has `all,coverage`, a row of a metric that may not be asked for.
TEST_F(CompareCommand, AFailedRunIsANewFailureOfWhicheverMetric) {
  auto b = fabricated_scores(kNoise, 1);
  std::erase_if(b, [](const FabricatedScore& s) { return s.sequence == "s2"; });
  for (std::uint64_t seed = 1; seed <= 8; ++seed) b.push_back({"s2", "all", "v", seed, "coverage", 0, true});
  write("b.csv", b);
  for (const std::vector<std::string>& options :
       {std::vector<std::string>{}, {"--metric", "d_shape_mean_m"}}) {
    const ProgramRun result = run(options);
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_NE(result.out.find("s2 v seeds 1-8: the whole runs"), std::string::npos) << result.out;
    EXPECT_EQ(result.out.find("missing in"), std::string::npos) << result.out;
  }
}

// Half a metre on one side, on the other no error at all, as the poses were given: neither is worse.
TEST_F(CompareCommand, GivenCameraPosesCompareWithNone) {
  const auto with_camera = [](double ape_m, const std::string& more) {
    auto scores = fabricated_scores(kNoise, 1);
    for (int sequence = 1; sequence <= 6; ++sequence)
      for (std::uint64_t seed = 1; seed <= 8; ++seed) {
        const std::string name = fmt::format("s{}", sequence);
        scores.push_back({name, "camera", "v", seed, "ape_translation_rmse_m", ape_m});
        if (!more.empty()) scores.push_back({name, "camera", "v", seed, more, 0.1});
      }
    return scores;
  };
  write("given.csv", with_camera(0, ""));
  write("estimated.csv", with_camera(0.5, "rpe_translation_rmse_m"));
  const auto answer = [&](const char* a, const char* b, std::vector<std::string> options) {
    options.insert(options.begin(), {"compare", path(a), path(b), "--json"});
    const ProgramRun result = run_program(options);
    EXPECT_EQ(result.exit_code, 0) << a << b << result.out;
    return json::parse(result.out);
  };
  EXPECT_EQ(answer("given.csv", "estimated.csv", {})["camera_given"], 96);
  EXPECT_EQ(answer("estimated.csv", "given.csv", {})["camera_given"], 96);
  EXPECT_EQ(answer("given.csv", "given.csv", {})["camera_given"], 48);
  const json chosen = answer("estimated.csv", "given.csv", {"--metric", "rpe_translation_rmse_m"});
  EXPECT_EQ(chosen["camera_given"], 48);
  EXPECT_EQ(chosen["metrics"].size(), 1u);  // of the object
  EXPECT_EQ(answer("estimated.csv", "estimated.csv", {})["camera_given"], 0);
}

TEST_F(CompareCommand, WritesJsonAndMarkdown) {
  auto b = another_run();
  scale(b, "iou3d_ellipsoid_mean", 0.9);
  write("b.csv", b);
  const ProgramRun result = run({"--json", "--markdown", path("out.md")});
  EXPECT_EQ(result.exit_code, 1);
  const json answer = json::parse(result.out);
  EXPECT_EQ(answer["answer"], "worse");
  EXPECT_EQ(answer["metrics"][0]["metric"], "iou3d_ellipsoid_mean");
  EXPECT_EQ(answer["counts"]["worse"], 1);
  EXPECT_EQ(answer["a"], path("a.csv"));
  EXPECT_EQ(result.out, run({"--json", "--threads", "1", "--quiet"}).out);
  const std::string markdown = read_text(path("out.md"));
  EXPECT_TRUE(markdown.starts_with("**worse: of 8 metrics 1 worse")) << markdown;
  const std::string before = read_text(path("a.csv"));
  expect_refused(run({"--markdown", path("a.csv")}), "a.csv");
  EXPECT_EQ(read_text(path("a.csv")), before);
  EXPECT_EQ(
      json::parse(run({"--json", "--metric", "coverage", "--metric", "iou2d_mean"}).out)["metrics"].size(),
      2u);
}

TEST_F(CompareCommand, IgnoresMetrics) {
  auto b = another_run();
  scale(b, "iou3d_ellipsoid_mean", 0.9);
  write("b.csv", b);
  const ProgramRun result = run({"--ignore", "iou3d_ellipsoid_mean", "--ignore", "coverage", "--json"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(json::parse(result.out)["metrics"].size(), 6u);
  expect_refused(run({"--ignore", "mota"}), "--ignore mota: neither");
}

std::size_t count_of(const std::string& text, const std::string& what) {
  std::size_t count = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++count;
  return count;
}

// Every element is closed in order, and no attribute has a bare quote or angle.
void expect_well_formed(const std::string& xml) {
  std::vector<std::string> open;
  std::size_t end = 0;
  for (std::size_t at = xml.find('<'); at != std::string::npos; at = xml.find('<', end)) {
    end = xml.find('>', at);
    ASSERT_NE(end, std::string::npos);
    const std::string tag = xml.substr(at + 1, end - at - 1);
    EXPECT_EQ(count_of(tag, "\"") % 2, 0u) << tag;
    EXPECT_EQ(tag.find('<'), std::string::npos) << tag;
    if (tag.front() == '?' || tag.back() == '/') continue;
    if (tag.front() != '/') {
      open.push_back(tag.substr(0, tag.find(' ')));
      continue;
    }
    ASSERT_FALSE(open.empty());
    EXPECT_EQ(tag.substr(1), open.back());
    open.pop_back();
  }
  EXPECT_TRUE(open.empty());
  for (std::size_t at = xml.find('&'); at != std::string::npos; at = xml.find('&', at + 1))
    EXPECT_LT(xml.find(';', at), at + 7);
}

TEST_F(CompareCommand, WritesJUnit) {
  const std::string odd = "a<b>&\"c'_m";
  auto a = fabricated_scores(kNoise, 1);
  a.push_back({"s1", "cube", odd, 1, odd, 0.1});
  auto b = a;
  scale(b, "d_shape_mean_m", 1.5);
  write("a.csv", a);
  write("b.csv", b);
  EXPECT_EQ(run({"--junit", path("out.xml")}).exit_code, 1);
  const std::string xml = read_text(path("out.xml"));
  expect_well_formed(xml);
  EXPECT_EQ(count_of(xml, "<testcase "), 10u);  // the answer and nine metrics
  EXPECT_EQ(count_of(xml, "<failure "), 2u);    // the answer and one metric
  EXPECT_EQ(count_of(xml, "<skipped "), 1u);
  EXPECT_NE(xml.find("tests=\"10\" failures=\"2\" errors=\"0\" skipped=\"1\""), std::string::npos) << xml;
  EXPECT_NE(xml.find("name=\"d_shape_mean_m\"><failure message=\"worse: A "), std::string::npos) << xml;
  EXPECT_NE(xml.find("name=\"a&lt;b&gt;&amp;&quot;c'_m\""), std::string::npos) << xml;
  expect_refused(run({"--junit", path("a.csv")}), "a.csv");
}

TEST_F(CompareCommand, NamesTheCommitsOfFolders) {
  for (const char* side : {"a", "b"}) {
    std::filesystem::create_directory(path(side));
    write(std::string(side) + "/scores.csv", fabricated_scores(kNoise, 1));
    write_text(path(side) + "/program.txt", std::string("uniquadric 0.1.0, commit ") + side + "1\n");
  }
  const ProgramRun apart = run_program({"compare", path("a"), path("b")});
  EXPECT_NE(apart.out.find("A  commit a1\nB  commit b1\n"), std::string::npos) << apart.out;
  write_text(path("b/program.txt"), "uniquadric 0.1.0, commit a1\n");
  const ProgramRun same = run_program({"compare", path("a"), path("b")});
  EXPECT_NE(same.out.find("B  commit a1 in " + path("b") + "\n"), std::string::npos) << same.out;
}

TEST_F(CompareCommand, TwoVariantsOfOneFolder) {
  auto both = fabricated_scores(kNoise, 1);
  auto other = another_run();
  scale(other, "iou3d_ellipsoid_mean", 0.9);
  for (FabricatedScore& score : other) score.variant = "w";
  both.insert(both.end(), other.begin(), other.end());
  write("scores.csv", both);
  const std::string folder = std::filesystem::path(path("scores.csv")).parent_path();
  EXPECT_EQ(run_program({"compare", folder, folder}).exit_code, 0);
  const ProgramRun result =
      run_program({"compare", folder, folder, "--variant-a", "v", "--variant-b", "w", "--json"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_EQ(json::parse(result.out)["metrics"][0]["variant"], "v -> w");
  EXPECT_EQ(run_program({"compare", folder, folder, "--variant-a", "w", "--variant-b", "v"}).exit_code, 0);
  const ProgramRun unknown = run_program({"compare", folder, folder, "--variant-a", "v", "--variant-b", "x"});
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_NE(unknown.err.find("has no variant 'x', but v, w"), std::string::npos) << unknown.err;
  EXPECT_EQ(run_program({"compare", folder, folder, "--variant-a", "v"}).exit_code, 2);
}

TEST_F(CompareCommand, RefusesBadInputByLine) {
  expect_refused(run({}), "b.csv: cannot be read");
  write_text(path("b.csv"), read_text(path("a.csv")) + "s1,cube,v,1,iou3d_ellipsoid_mean,half,higher,ok\n");
  expect_refused(run({"--json", "--markdown", path("out.md")}),
                 "b.csv:386: value 'half' is no finite number");
  EXPECT_FALSE(std::filesystem::exists(path("out.md")));
  write("b.csv", another_run());
  expect_refused(run({"--metric", "mota"}), "has no metric 'mota'");
}

}  // namespace
}  // namespace uniquadric
