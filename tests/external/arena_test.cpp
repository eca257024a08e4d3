// Programs of others in a bench: what they may do, and what whatever they do leaves unharmed.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <map>

#include "core/base/files.h"
#include "core/base/text.h"
#include "evaluation/results/results.h"
#include "harness/external/sandbox.h"
#include "tests/harness/program.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

// A whole result of one object that stands still, with the stamps of the sequence.
constexpr const char* kGood = R"(
poses() { awk -v shift="$1" '!/^#/ { printf "%.6f %s 0 0.5 0 0 0 1\n", $1 + shift, 0.1 }' "$SEQUENCE/rgb.txt"; }
mkdir "$OUT/objects"
poses 0 > "$OUT/camera.tum"
poses 0 > "$OUT/objects/1.tum"
echo '1: {size_m: [0.4, 0.3, 0.2]}' > "$OUT/objects.yaml"
)";

class Arena : public testing::Test {
 protected:
  void SetUp() override { write_text(folder() / "small.yaml", small_scene_yaml()); }
  const fs::path& folder() const { return temp_.path(); }
  fs::path out() const { return folder() / "out"; }

  void add(const std::string& name, const std::string& script, const std::string& more = "") {
    write_text(folder() / (name + ".sh"), "SEQUENCE=$1 OUT=$2 SEED=$3\n" + script);
    write_text(
        folder() / (name + ".yaml"),
        fmt::format(
            "schema: 1\nname: {0}\ncommand: [sh, {0}.sh, \"{{sequence}}\", \"{{out}}\", \"{{seed}}\"]\n{1}",
            name, more));
    variants_ += (variants_.empty() ? "" : ", ") + name + ".yaml";
  }
  ProgramRun bench() const {
    write_text(folder() / "bench.yaml",
               "scenes: [small.yaml]\nvariants: [" + variants_ + "]\nseeds: [1]\noverlays: 1\n");
    return run_program({"bench", folder() / "bench.yaml", out(), "--quiet"});
  }
  std::map<std::string, Cell> cells() const {
    std::map<std::string, Cell> cells;
    for (const Cell& cell : read_cells(out() / "cells.csv")) cells[cell.variant] = cell;
    return cells;
  }

 private:
  TempFolder temp_;
  std::string variants_;
};

TEST_F(Arena, WhateverAProgramDoesIsOneFailedCellWithItsReason) {
  const std::string limits = "limits: {time_s: 1, memory_mb: 60, output_mb: 5}\n";
  const std::map<std::string, std::pair<std::string, std::string>> bad = {
      {"crash", {"kill -SEGV $$", "was ended by signal 11"}},
      {"error", {"echo 'no weights' >&2; exit 4", "exit code 4: no weights"}},
      {"hang", {"sleep 100", "ran longer than 1 s"}},
      {"hog", {"head -c 300000000 /dev/zero | tail -c 300000000", "used more than 60 MB of memory"}},
      {"flood", {"head -c 100000000000 /dev/zero > \"$OUT/x\"", "wrote more than 5 MB"}},
      {"many",
       {"for i in $(seq 100); do head -c 1000000 /dev/zero > \"$OUT/$i\"; done; sleep 1",
        "wrote more than 5 MB"}},
      {"empty", {"true", "has neither objects.yaml"}},
      {"half",
       {kGood + std::string("printf '0.1 0 0' >> \"$OUT/camera.tum\""), "camera.tum:5: expected 8 numbers"}},
      {"sizeless", {kGood + std::string("rm \"$OUT/objects.yaml\""), "objects.yaml has no size of object 1"}},
      {"wrong_id",
       {kGood + std::string("cp \"$OUT/objects/1.tum\" \"$OUT/objects/zero.tum\""),
        "objects/zero.tum: is named by no id"}},
      {"other",
       {kGood + std::string("poses 5000 > \"$OUT/camera.tum\"; poses 5000 > \"$OUT/objects/1.tum\""),
        "lies within half a frame"}},
      {"link", {"ln -s /etc/passwd \"$OUT/camera.tum\"", "camera.tum: is neither a file nor a folder"}},
      {"pipe",
       {kGood + std::string("mkfifo \"$OUT/objects/2.tum\""),
        "objects/2.tum: is neither a file nor a folder"}},
  };
  add("good", kGood, "limits: {time_s: 20}\n");
  for (const auto& [name, program] : bad) add(name, program.first, limits);
  const ProgramRun run = bench();
  EXPECT_EQ(run.exit_code, 2) << run.err;
  const auto by_variant = cells();
  ASSERT_EQ(by_variant.size(), bad.size() + 1);
  EXPECT_EQ(by_variant.at("good").status, CellStatus::ok) << by_variant.at("good").message;
  for (const auto& [name, program] : bad) {
    const Cell& cell = by_variant.at(name);
    EXPECT_EQ(cell.status, CellStatus::failed) << name;
    EXPECT_NE(cell.message.find(program.second), std::string::npos) << name << ": " << cell.message;
    EXPECT_FALSE(fs::exists(out() / cell.folder / "estimate")) << name;
    EXPECT_EQ(cell.message.find(folder().string()), std::string::npos) << cell.message;
  }
  for (const auto& entry : fs::recursive_directory_iterator(out()))
    EXPECT_NE(entry.path().extension(), ".partial") << entry.path();
}

// Rows beside ours, which a second call leaves as they are; cells of sequences without a sensor do not fail.
TEST_F(Arena, AProgramHasRowsLikeAnyVariant) {
  add("good", kGood);
  add("needs_lidar", "exit 1", "sensors: [lidar]\n");
  ProgramRun run = bench();
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(cells().at("needs_lidar").status, CellStatus::not_applicable);
  EXPECT_EQ(cells().at("needs_lidar").message, "the sequence has no lidar");
  const std::string scores = read_text(out() / "scores.csv");
  for (const char* row : {"small,box,good,1,coverage", "small,camera,good,1,ape_translation_rmse_m"})
    EXPECT_NE(scores.find(row), std::string::npos) << row;
  for (const char* metric : {"wall_time_s", "cpu_time_s", "peak_memory_mb"})
    EXPECT_NE(scores.find(fmt::format("small,all,good,1,{}", metric)), std::string::npos) << metric;
  EXPECT_EQ(scores.find("needs_lidar"), std::string::npos);
  run = bench();
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(read_text(out() / "scores.csv"), scores);  // measured times in it: nothing ran again
  EXPECT_EQ(run_program({"report", out()}).exit_code, 0);
  EXPECT_EQ(read_text(out() / "scores.csv"), scores);
  const ProgramRun compared = run_program({"compare", out(), out()});
  EXPECT_NE(compared.exit_code, 1) << compared.out;
  EXPECT_NE(compared.out.find("good"), std::string::npos) << compared.out;
}

TEST_F(Arena, WhatAProgramKnowsLaterHasRowsOfItsOwn) {
  add("later", kGood + std::string("mkdir \"$OUT/final\"; cp -r \"$OUT/camera.tum\" \"$OUT/objects\" "
                                   "\"$OUT/objects.yaml\" \"$OUT/final\"\n"));
  ASSERT_EQ(bench().exit_code, 0);
  const std::string scores = read_text(out() / "scores.csv");
  for (const char* row : {"small,box,later,1,coverage", "small,box,later@final,1,coverage"})
    EXPECT_NE(scores.find(row), std::string::npos) << row;
  EXPECT_EQ(scores.find("later@fixed_lag"), std::string::npos);
}

TEST_F(Arena, AChangedInputRunsAgain) {
  add("good", kGood);
  ASSERT_EQ(bench().exit_code, 0);
  const std::string usage = read_text(out() / "cells/small/good/seed_1/estimate/usage.csv");
  write_text(folder() / "good.sh", read_text(folder() / "good.sh") + "sleep 0.3\n");
  ASSERT_EQ(bench().exit_code, 0);
  EXPECT_NE(read_text(out() / "cells/small/good/seed_1/estimate/usage.csv"), usage);
}

// It is told where the truth is, and looks everywhere.
TEST_F(Arena, AProgramThatLooksForTheTruthFindsNone) {
  if (!can_isolate()) GTEST_SKIP() << "bubblewrap cannot run here";
  const fs::path truth = out() / "simulations/small/seed_1/truth";
  constexpr const char* kSpy = R"sh(
for path in "$TRUTH" "$SEQUENCE/../truth" /proc/1/root"$TRUTH" /proc/self/root"$TRUTH" "$OUT/../truth" /proc/*/cwd/truth; do
  [ -e "$path/camera.tum" ] && { echo "found $path"; exit 1; }
done
seen=$(find / \( -name visibility.csv -o -name map.bt -o -name camera_given.tum -o -path '*/truth/objects.yaml' \) 2>/dev/null)
[ -z "$seen" ] || { echo "found $seen"; exit 1; }
ls "$SEQUENCE"/hashes.txt 2>/dev/null && exit 1
touch "$SEQUENCE/x" 2>/dev/null && { echo "wrote into the sequence"; exit 1; }
touch "$TRUTH/../x" /usr/x 2>/dev/null && { echo "wrote outside"; exit 1; }
[ "$(tail -n +3 /proc/net/dev | grep -vc ' lo:')" = 0 ] || { echo "has a network"; exit 1; }
[ -r "$SEQUENCE/rgb.txt" ]
)sh";
  add("spy", "TRUTH='" + truth.string() + "'\n" + kGood + kSpy);
  const ProgramRun run = bench();
  EXPECT_EQ(run.exit_code, 0) << run.err << cells().at("spy").message;
  EXPECT_EQ(read_cell_evaluation(out() / "cells/small/spy/seed_1/evaluation").isolation, "bubblewrap");
}  // namespace uniquadric

// An input or a mount that holds the sequence's folder would show it.
TEST_F(Arena, AMountThatHoldsTheTruthIsRefused) {
  add("open", kGood, "mounts: [" + folder().string() + "]\n");
  EXPECT_EQ(bench().exit_code, 2);
  EXPECT_NE(cells().at("open").message.find("would see the truth"), std::string::npos)
      << cells().at("open").message;
}

}  // namespace
}  // namespace uniquadric
