// A bench that is killed, runs out of disk or memory, or has a stage that crashes or hangs: what then stands
// under a final name is whole, and the same call goes on to the bytes of a run that nothing disturbed.
#include <gtest/gtest.h>
#include <sys/mount.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <random>
#include <thread>

#include "core/base/files.h"
#include "tests/faults/faulty_bench.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

class Faults : public testing::Test {
 protected:
  void SetUp() override {
    const auto start = std::chrono::steady_clock::now();
    const ProgramRun run = run_program({"bench", bench_, folder() / "whole", "--quiet", "--keep"});
    duration_ = std::chrono::steady_clock::now() - start;
    ASSERT_EQ(run.exit_code, 0) << run.err;
    whole_ = results_in(folder() / "whole");
    for (const char* file :
         {"scores.csv", "cells/small/single_frame_obb/seed_2/evaluation/evaluation.json",
          "simulations/small/seed_1/sequence/rgb/000002.png", "simulations/small/seed_1.key"})
      ASSERT_TRUE(whole_.contains(file)) << file;
  }

  const fs::path& folder() const { return temp_.path(); }

  void expect_to_go_on(const fs::path& out) const {
    const ProgramRun run = run_program({"bench", bench_, out, "--quiet"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const auto results = results_in(out);
    EXPECT_EQ(results.size(), without_sequences(whole_).size());
    EXPECT_TRUE(results == without_sequences(whole_));
    expect_nothing_torn(out, whole_);  // says which
  }

  TempFolder temp_;
  fs::path bench_ = write_faulty_bench(temp_.path());
  std::map<std::string, std::string> whole_;  // with the sequences
  std::chrono::duration<double> duration_{};
};

// Gone on with until it comes to its end; then from the beginning again.
TEST_F(Faults, ABenchKilledAtAnyMoment) {
  constexpr int kKills = 20;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> moment(0, 0.6);  // of an undisturbed run: they go on with each other
  const fs::path out = folder() / "out";
  int killed = 0, ended = 0;
  while (killed < kKills) {
    const pid_t process = start_bench(bench_, out);
    std::this_thread::sleep_for(duration_ * moment(random));
    if (!kill_bench(process, killed % 2 == 1)) {
      ++killed;
      expect_nothing_torn(out, whole_);
      continue;
    }
    ++ended;
    expect_to_go_on(out);
    fs::remove_all(out);
  }
  expect_to_go_on(out);
  RecordProperty("ended", ended);
}

// One after the other in one folder: each call goes on where the one before went wrong.
TEST_F(Faults, AStageThatCrashesOrHangs) {
  const fs::path out = folder() / "out", hasty = folder() / "hasty";
  fs::create_directories(hasty);
  const fs::path with_limit = write_faulty_bench(hasty, "stage_limit_s: 2\n");
  struct Case {
    const char *fault, *message;
  };
  // evaluate gives three files their names, then the folder, then its key.
  for (const Case& c :
       {Case{"simulate crash 5", "simulate: uniquadric: internal error: a worker was ended by signal 11"},
        Case{"simulate hang 9", "simulate: ran longer than 2 s"},
        Case{"perceive kill 2", "perceive: killed by signal 9"},
        Case{"estimate crash 1", "estimate: killed by signal 11"},
        Case{"evaluate kill 3", "evaluate: killed by signal 9"},
        Case{"evaluate crash 4", "evaluate: killed by signal 11"},
        Case{"evaluate kill 5", "evaluate: killed by signal 9"},
        Case{"overlay hang 1", "overlay: ran longer than 2 s"}}) {
    const bool hangs = std::string(c.fault).find("hang") != std::string::npos;
    const ProgramRun run = run_with_fault(c.fault, hangs ? with_limit : bench_, out);
    EXPECT_EQ(run.exit_code, 2) << c.fault << run.err;
    EXPECT_NE(read_text(out / "cells.csv").find(c.message), std::string::npos)
        << c.fault << read_text(out / "cells.csv");
    fs::remove(out / "cells.csv");  // these say of what went wrong
    for (const char* name : {"scores.csv", "report.md"}) fs::remove(out / name);
    if (hangs) fs::remove(out / "inputs.csv");  // has the hash of the bench file with the limit
    expect_nothing_torn(out, whole_);
  }
  expect_to_go_on(out);
}

TEST_F(Faults, AStageOutOfMemory) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a sanitizer needs terabytes of addresses";
#endif
  const fs::path out = folder() / "out";
  for (const std::string stage : {"simulate", "perceive", "estimate", "evaluate"}) {
    const ProgramRun run = run_with_fault(stage + " memory 1", bench_, out);
    EXPECT_EQ(run.exit_code, 2) << stage << run.err;
    EXPECT_NE(read_text(out / "cells.csv").find(stage + ": "), std::string::npos)
        << read_text(out / "cells.csv");
    for (const char* name : {"cells.csv", "scores.csv", "report.md"}) fs::remove(out / name);
    expect_nothing_torn(out, whole_);
  }
  expect_to_go_on(out);
}

// A file system of its own.
class SmallDisk {
 public:
  explicit SmallDisk(fs::path folder) : folder_(std::move(folder)) {
    fs::create_directories(folder_);
    is_mounted_ = mount("none", folder_.c_str(), "tmpfs", 0, "size=1m") == 0;
  }
  ~SmallDisk() {
    if (is_mounted_) umount2(folder_.c_str(), MNT_DETACH);
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;
  bool is_mounted() const { return is_mounted_; }
  bool remount(const std::string& options, unsigned long flags = 0) const {
    return mount("none", folder_.c_str(), "tmpfs", MS_REMOUNT | flags, options.c_str()) == 0;
  }

 private:
  fs::path folder_;
  bool is_mounted_ = false;
};

TEST_F(Faults, ADiskThatIsFull) {
  const SmallDisk disk(folder() / "disk");
  if (!disk.is_mounted()) GTEST_SKIP() << "a file system cannot be mounted: " << std::strerror(errno);
  const fs::path out = folder() / "disk/out";
  for (const char* size : {"size=24k", "size=200k", "size=500k", "size=800k", "size=1000k"}) {
    ASSERT_TRUE(disk.remount(size)) << size << std::strerror(errno);
    const ProgramRun run = run_program({"bench", bench_, out, "--quiet"});
    EXPECT_EQ(run.exit_code, 2) << size;
    EXPECT_NE(run.err.find("uniquadric: "), std::string::npos) << run.err;
    for (const char* name : {"cells.csv", "scores.csv", "report.md"}) fs::remove(out / name);
    expect_nothing_torn(out, whole_);
  }
  ASSERT_TRUE(disk.remount("size=64m"));
  expect_to_go_on(out);
}

TEST_F(Faults, AnOutputThatCannotBeWritten) {
  const SmallDisk disk(folder() / "disk");
  if (!disk.is_mounted()) GTEST_SKIP() << "a file system cannot be mounted: " << std::strerror(errno);
  ASSERT_TRUE(disk.remount("size=64m"));
  const fs::path out = folder() / "disk/out";
  const auto refused = [&] {
    ASSERT_TRUE(disk.remount("size=64m", MS_RDONLY)) << std::strerror(errno);
    expect_refused(run_program({"bench", bench_, out, "--quiet"}), "Read-only file system");
    ASSERT_TRUE(disk.remount("size=64m")) << std::strerror(errno);
  };
  refused();
  EXPECT_FALSE(fs::exists(out));
  run_with_fault("estimate crash 1", bench_, out);
  const auto half = results_in(out);
  refused();
  EXPECT_TRUE(results_in(out) == half);
  expect_to_go_on(out);
}

}  // namespace
}  // namespace uniquadric
