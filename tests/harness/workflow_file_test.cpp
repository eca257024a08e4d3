// The workflow that judges pull requests, which nothing here runs: that it is YAML, and what it calls is
// there.
#include <gtest/gtest.h>

#include <filesystem>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include "core/base/config.h"
#include "tests/harness/program.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

const fs::path kSource = UNIQUADRIC_SOURCE_DIR;

std::vector<std::string> words(const std::string& command) {
  std::istringstream in(command);
  return {std::istream_iterator<std::string>(in), {}};
}

// The path inside one of the two checkouts; empty for another word.
std::string in_checkout(const std::string& word) {
  for (const std::string checkout : {"before/", "after/"})
    if (word.starts_with(checkout)) return word.substr(checkout.size());
  return {};
}

void expect_options(const std::vector<std::string>& command) {
  ASSERT_GT(command.size(), 1u);
  const ProgramRun help = run_program({command[1], "--help"});
  EXPECT_EQ(help.exit_code, 0) << command[1];
  for (const std::string& word : command)
    if (word.starts_with("--")) {
      EXPECT_NE(help.out.find(word + " "), std::string::npos) << word;
    }
}

TEST(WorkflowFile, IsYamlWhoseCommandsExist) {
  const ConfigNode gate = ConfigNode::load(kSource / ".github/workflows/gate.yaml");
  EXPECT_EQ(gate.get<std::string>("on"), "pull_request");
  int scripts = 0, programs = 0, configs = 0;
  for (const ConfigNode& step : gate.at("jobs").at("gate").at("steps").items()) {
    EXPECT_NE(step.has("uses"), step.has("run")) << step.line();
    if (!step.has("run")) continue;
    const std::vector<std::string> command = words(step.get<std::string>("run"));
    const std::string called = in_checkout(command.front());
    if (called == "build/release/harness/uniquadric") {  // as scripts/bench calls it
      expect_options(command);
      ++programs;
    } else if (!called.empty()) {
      EXPECT_NE(fs::status(kSource / called).permissions() & fs::perms::owner_exec, fs::perms::none)
          << called;
      ++scripts;
    }
    for (const std::string& word : command)
      if (word.starts_with("configs/")) {
        EXPECT_TRUE(fs::exists(kSource / word)) << word;
        ++configs;
      }
  }
  EXPECT_EQ(scripts, 2);
  EXPECT_EQ(programs, 2);
  EXPECT_EQ(configs, 2);
}

TEST(WorkflowFile, OfTestsAndLintCallScriptsThatExist) {
  int scripts = 0;
  for (const auto& [file, job] : {std::pair("systems", "test"), std::pair("lint", "lint")}) {
    const ConfigNode workflow =
        ConfigNode::load(kSource / ".github/workflows" / (std::string(file) + ".yaml"));
    EXPECT_EQ(workflow.get<std::string>("on"), "pull_request");
    for (const ConfigNode& step : workflow.at("jobs").at(job).at("steps").items()) {
      EXPECT_NE(step.has("uses"), step.has("run")) << step.line();
      const std::string called = step.has("run") ? words(step.get<std::string>("run")).front() : "";
      if (!called.starts_with("scripts/")) continue;
      EXPECT_NE(fs::status(kSource / called).permissions() & fs::perms::owner_exec, fs::perms::none)
          << called;
      ++scripts;
    }
  }
  EXPECT_EQ(scripts, 2);
}

}  // namespace
}  // namespace uniquadric
