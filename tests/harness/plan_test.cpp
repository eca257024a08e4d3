// What `bench --plan` prints can be run by anything that runs commands in order.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "core/base/files.h"
#include "core/base/hash.h"
#include "simulator/scene/scene.h"
#include "tests/harness/program.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

class BenchPlanCommand : public testing::Test {
 protected:
  void SetUp() override {
    write_text(folder() / "small.yaml", small_scene_yaml());
    const fs::path variants = fs::path(UNIQUADRIC_SOURCE_DIR) / "configs/variants";
    write_text(bench_, "scenes: [small.yaml]\nvariants: [" + (variants / "rotbbox.yaml").string() + ", " +
                           (variants / "bbox.yaml").string() + "]\nseeds: [1, 2]\noverlays: 1\nframes: 3\n");
  }
  const fs::path& folder() const { return temp_.path(); }
  std::vector<json> plan(const fs::path& out) const {
    const ProgramRun run = run_program({"bench", bench_, out, "--plan"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    std::vector<json> stages;
    std::istringstream lines(run.out);
    for (std::string line; std::getline(lines, line);) stages.push_back(json::parse(line));
    return stages;
  }
  static std::string scores(const fs::path& out) {
    std::string kept;
    std::istringstream lines(read_text(out / "scores.csv"));
    for (std::string line; std::getline(lines, line);)
      if (line.find("frame_time_mean_ms") == std::string::npos &&
          line.find("_time_s,") == std::string::npos && line.find("peak_memory_mb") == std::string::npos)
        kept += line + '\n';  // what is not measured
    return kept;
  }

  TempFolder temp_;
  fs::path bench_ = temp_.path() / "bench.yaml";
};

TEST_F(BenchPlanCommand, RunsNothingAndNamesInputsFirst) {
  const fs::path out = folder() / "out";
  const std::vector<json> stages = plan(out);
  EXPECT_FALSE(fs::exists(out));
  std::map<std::string, int> count;
  std::set<std::string> folders;
  for (const json& stage : stages) {
    ++count[stage["stage"]];
    for (const std::string input : stage.value("inputs", json::array()))
      EXPECT_TRUE(folders.contains(input)) << stage;
    EXPECT_TRUE(folders.insert(stage["folder"]).second) << stage;
  }
  // Two seeds, two variants, of which both look at the images with the same options.
  const std::map<std::string, int> expected = {{"simulate", 2}, {"perceive", 2}, {"estimate", 4},
                                               {"evaluate", 4}, {"overlay", 4},  {"scenery", 1},
                                               {"report", 1}};
  EXPECT_EQ(count, expected);
  EXPECT_EQ(stages.back()["stage"], "report");
}

TEST_F(BenchPlanCommand, ItsCommandsMakeWhatBenchMakes) {
  const fs::path out = folder() / "out", by_bench = folder() / "by_bench";
  ASSERT_EQ(run_program({"bench", bench_, by_bench, "--quiet"}).exit_code, 0);
  fs::path last;
  for (const json& stage : plan(out)) {
    fs::create_directories(fs::path(stage["folder"]).parent_path());
    const ProgramRun run = run_program(stage["command"]);
    ASSERT_EQ(run.exit_code, 0) << run.err;
    if (stage["stage"] == "evaluate") last = fs::path(stage["folder"]) / "frames.csv";
  }
  EXPECT_EQ(scores(out), scores(by_bench));
  for (const char* name : {"program.txt", "inputs.csv"})
    EXPECT_EQ(read_text(out / name), read_text(by_bench / name)) << name;
  std::string program = run_program({"--version"}).out;
  program.replace(program.find('\n'), 1, ", ");
  EXPECT_EQ(read_text(out / "program.txt"), program);
  EXPECT_TRUE(program.find(", commit ") != program.npos || program.find(", no known") != program.npos);
  const std::string inputs = read_text(out / "inputs.csv");
  EXPECT_TRUE(inputs.starts_with("kind,name,hash\nbench,bench," + hex(hash_file(bench_)) + "\n")) << inputs;
  EXPECT_NE(inputs.find("\nscene,small," + load_scene(folder() / "small.yaml").hash + "\n"), inputs.npos)
      << inputs;
  EXPECT_NE(inputs.find("\nvariant,bbox,"), inputs.npos) << inputs;
  EXPECT_EQ(read_text(out / "cells.csv"), read_text(by_bench / "cells.csv"));
  const auto made = fs::last_write_time(last);
  ASSERT_EQ(run_program({"bench", bench_, out, "--quiet"}).exit_code, 0);
  EXPECT_EQ(fs::last_write_time(last), made) << "bench takes them for its own";
  for (const json& stage : plan(out)) {
    if (stage["stage"] != "evaluate") continue;
    ASSERT_EQ(run_program(stage["command"]).exit_code, 0);
  }
  EXPECT_EQ(fs::last_write_time(last), made) << "and they are not made twice";
}

TEST_F(BenchPlanCommand, DrawsTheScenesThatGenerateDraws) {
  const fs::path out = folder() / "out",
                 variant = fs::path(UNIQUADRIC_SOURCE_DIR) / "configs/variants/bbox.yaml";
  write_text(bench_,
             "scenes: [{family: tabletop, name: t, count: 3, first_seed: 7, set: {frames: 9}}]\nvariants: [" +
                 variant.string() + "]\nseeds: [1]\n");
  plan(out);
  for (const std::string seed : {"7", "8", "9"}) {
    const fs::path drawn = folder() / ("drawn_" + seed + ".yaml");
    ASSERT_EQ(run_program({"generate", "tabletop", drawn, "--seed", seed, "--set", "frames=9"}).exit_code, 0);
    std::string text = read_text(drawn);  // with the hash of its body, for --force
    const std::size_t end = text.find('\n'), note = text.find(", body ");
    ASSERT_LT(note, end);
    EXPECT_EQ(read_text(out / "scenes" / ("t_" + seed + ".yaml")),
              text.substr(0, note) + '.' + text.substr(end));
  }
}

TEST_F(BenchPlanCommand, RefusesSeedsOfAFamilyBeyondTheLargest) {
  write_text(bench_, "scenes: [{family: room, count: 2, first_seed: 18446744073709551615}]\nvariants: [" +
                         (fs::path(UNIQUADRIC_SOURCE_DIR) / "configs/variants/bbox.yaml").string() +
                         "]\nseeds: [1]\n");
  const ProgramRun run = run_program({"bench", bench_, folder() / "out", "--plan"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.err.find(bench_.string() + ":1: scenes[0].first_seed: "), run.err.npos) << run.err;
}

// Two variants of one file, one of them with another option of the back end, are two rows that share what is
// seen.
TEST_F(BenchPlanCommand, SetsValuesInAVariantsPlace) {
  const fs::path file = fs::path(UNIQUADRIC_SOURCE_DIR) / "configs/variants/bbox.yaml",
                 out = folder() / "out";
  write_text(bench_, "scenes: [small.yaml]\nvariants:\n  - " + file.string() +
                         "\n  - {variant: " + file.string() +
                         ", name: soft, set: {long_window.rigid_prior: soft}}\nseeds: [1]\noverlays: 0\n"
                         "frames: 3\n");
  std::map<std::string, int> count;
  for (const json& stage : plan(out)) ++count[stage["stage"]];
  EXPECT_EQ(count["perceive"], 1);
  ASSERT_EQ(run_program({"bench", bench_, out, "--quiet"}).exit_code, 0);
  const std::string run = read_text(out / "cells/small/soft/seed_1/estimate/run.yaml");
  EXPECT_NE(run.find("name: \"soft\""), run.npos) << run;
  EXPECT_NE(run.find("rigid_prior: soft"), run.npos);
  EXPECT_NE(read_text(out / "cells/small/bbox/seed_1/estimate/run.yaml").find("rigid_prior: none"), run.npos);
  const fs::path alone = folder() / "alone";
  ASSERT_EQ(
      run_program({"simulate", folder() / "small.yaml", folder() / "data", "--frames", "3", "--seed", "1"})
          .exit_code,
      0);
  ASSERT_EQ(run_program({"estimate", folder() / "data/sequence", alone, "--variant", file, "--seed", "1",
                         "--set", "long_window.rigid_prior=soft", "--set", "name=soft"})
                .exit_code,
            0);
  EXPECT_EQ(read_text(alone / "objects.csv"),
            read_text(out / "cells/small/soft/seed_1/estimate/objects.csv"));
}

TEST_F(BenchPlanCommand, RefusesWhatCannotBeSetInAVariant) {
  const fs::path file = fs::path(UNIQUADRIC_SOURCE_DIR) / "configs/variants/bbox.yaml";
  write_text(folder() / "own.yaml", "name: own\ncommand: [\"true\"]\n");
  const std::string at = bench_.string() + ":2: ";
  for (const auto& [entry, message] : std::vector<std::pair<std::string, std::string>>{
           {"{variant: " + file.string() + ", name: a, set: {no_such: 1}}", at + "variants[0].set.no_such"},
           {"{variant: " + file.string() + ", set: {smooth: true}}", at + "variants[0]: "},
           {"{variant: own.yaml, name: a, set: {smooth: true}}", at + "variants[0].set: "},
           {"{variant: own.yaml, name: a@final}", at + "variants[0]: 'a@final': an @"},
           {"{variant: own.yaml, name: ..}", at + "variants[0].name: "}}) {
    write_text(bench_, "scenes: [small.yaml]\nvariants: [" + entry + "]\nseeds: [1]\n");
    const ProgramRun run = run_program({"bench", bench_, folder() / "out", "--plan"});
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_NE(run.err.find(message), run.err.npos) << run.err;
  }
}

// With one cell failed and one never run.
TEST_F(BenchPlanCommand, CollectTellsWhatIsThere) {
  const fs::path out = folder() / "out";
  ASSERT_EQ(run_program({"bench", bench_, out, "--quiet"}).exit_code, 0);
  const fs::path failed = out / "cells/small/bbox/seed_1", missing = out / "cells/small/bbox/seed_2";
  for (const fs::path& cell : {failed, missing}) fs::remove(cell / "evaluation.key");
  write_text(failed / "log.txt", "a note\nuniquadric: it broke\n");
  const ProgramRun run = run_program({"bench", bench_, out, "--collect", "--quiet"});
  EXPECT_EQ(run.exit_code, 2);
  const std::string cells = read_text(out / "cells.csv");
  for (const char* row :
       {"small,rotbbox,1,ok,", "small,bbox,1,failed,", "uniquadric: it broke", "small,bbox,2,missing,"})
    EXPECT_NE(cells.find(row), std::string::npos) << cells;
  EXPECT_FALSE(fs::exists(failed / "evaluation.key")) << "nothing was run";
}

}  // namespace
}  // namespace uniquadric
