#include "harness/external/process_tree.h"

#include <gtest/gtest.h>
#include <signal.h>

#include <fstream>

#include "core/base/files.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

class ProcessTree : public testing::Test {
 protected:
  TreeResult run(const std::string& script) const {
    return run_tree({{"sh", "-c", script}, {"PATH=/usr/bin:/bin"}, temp_.path()}, limits_, Printing::hidden);
  }
  const fs::path& folder() const { return temp_.path(); }

  TempFolder temp_;
  TreeLimits limits_{10, 500, 10, temp_.path()};
};

TEST_F(ProcessTree, AnEndWithoutErrorIsNoFailure) {
  const TreeResult result = run("read line; echo \"[$line]\" > seen");
  EXPECT_EQ(result.failure, "");
  EXPECT_EQ(read_text(folder() / "seen"), "[]\n");  // standard input is empty
}

TEST_F(ProcessTree, AFailureIsToldByItsLastLine) {
  EXPECT_EQ(run("echo begin; echo no such weights >&2; exit 3").failure, "exit code 3: no such weights");
  EXPECT_EQ(run("kill -SEGV $$").failure, "was ended by signal 11 (Segmentation fault)");
  const TreeResult absent =
      run_tree({{"no_such_program"}, {"PATH=/usr/bin"}, folder()}, limits_, Printing::hidden);
  EXPECT_EQ(absent.failure, "exit code 127: no_such_program: No such file or directory");
}

// A child that left its group and session and whose parent is gone ends with the tree.
TEST_F(ProcessTree, NothingOfTheTreeOutlivesIt) {
  limits_.time_s = 0.5;
  const std::string leave = "setsid sh -c 'echo $$ > pid; exec sleep 60' & ";
  for (const char* end : {"sleep 0.2; exit 0", "sleep 60"}) {
    const TreeResult result = run(leave + end);
    EXPECT_EQ(result.failure, std::string(end) == "sleep 60" ? "ran longer than 0.5 s" : "");
    pid_t pid = 0;
    std::ifstream(folder() / "pid") >> pid;
    ASSERT_GT(pid, 0);
    EXPECT_NE(kill(pid, 0), 0);
    fs::remove(folder() / "pid");
  }
}

TEST_F(ProcessTree, LimitsAreOfTheWholeTree) {
  limits_.memory_mb = 60;
  const std::string hold = "head -c 40000000 /dev/zero | tail -c 40000000 | (sleep 5; cat) >/dev/null";
  EXPECT_EQ(run(hold + " & " + hold).failure, "used more than 60 MB of memory");
  EXPECT_EQ(run("mkdir -p a/b; for i in 1 2 3; do head -c 4000000 /dev/zero > a/b/$i; done; sleep 5").failure,
            "wrote more than 10 MB");
  EXPECT_EQ(run("exec head -c 20000000 /dev/zero > one").failure, "wrote more than 10 MB");
}

TEST_F(ProcessTree, TellsWhatItTook) {
  const TreeResult result = run("i=0; while [ $i -lt 200000 ]; do i=$((i + 1)); done; sleep 0.3");
  EXPECT_EQ(result.failure, "");
  EXPECT_GT(result.usage.cpu_time_s, 0.02);
  EXPECT_GE(result.usage.wall_time_s, result.usage.cpu_time_s + 0.25);
  const TreeResult large = run("head -c 100000000 /dev/zero | tail -c 100000000 | sha1sum");
  EXPECT_GT(large.usage.peak_memory_mb, 90);
  EXPECT_LT(result.usage.peak_memory_mb, 20);
}

TEST_F(ProcessTree, SeesItsEnvironmentAlone) {
  setenv("UNIQUADRIC_SECRET", "yes", 1);
  EXPECT_EQ(run("[ -z \"$UNIQUADRIC_SECRET\" ]").failure, "");
}

}  // namespace
}  // namespace uniquadric
