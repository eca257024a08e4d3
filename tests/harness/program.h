#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace uniquadric {

struct ProgramRun {
  int exit_code = -1;
  std::string out, err;
};

/// Runs the program `uniquadric` with arguments and standard input; exit_code 128 + signal when it was
/// killed.
ProgramRun run_program(const std::vector<std::string>& arguments, const std::string& input = "");

/// Expects exit code 2, and `what` in one line on standard error alone.
void expect_refused(const ProgramRun& run, const std::string& what);

/// Hash of every file's name and bytes below a folder, except files named as in `ignored`.
std::string folder_hash(const std::filesystem::path& folder, const std::vector<std::string>& ignored = {});

/// A small scene of two moving boxes in a room, few pixels: fast to render.
std::string small_scene_yaml();

}  // namespace uniquadric
