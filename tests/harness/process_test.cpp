// Stages as processes of their own.
#include "harness/bench/process.h"

#include <gtest/gtest.h>

#include <chrono>

#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {

TEST(Process, AHangingStageIsEndedAtItsLimit) {
  const TempFolder temp;
  const auto start = std::chrono::steady_clock::now();
  const ProcessResult result = run_process({"/bin/sleep", "60"}, temp.path() / "log", 0.2);
  EXPECT_FALSE(result.ok);
  EXPECT_EQ(result.message, "ran longer than 0.2 s");
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(30));
}

TEST(Process, SaysWhyAStageFailed) {
  const TempFolder temp;
  EXPECT_EQ(
      run_process({"/bin/sh", "-c", "echo first; echo last >&2; exit 3"}, temp.path() / "a", 10).message,
      "last");
  EXPECT_EQ(run_process({"/bin/sh", "-c", "kill -SEGV $$"}, temp.path() / "b", 10).message,
            "killed by signal 11 (Segmentation fault)");
  EXPECT_EQ(run_process({"/bin/false"}, temp.path() / "c", 10).message, "exit code 1");
  EXPECT_TRUE(run_process({"/bin/true"}, temp.path() / "d", 10).ok);
}

}  // namespace
}  // namespace uniquadric
