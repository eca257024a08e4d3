#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace uniquadric {

struct ProcessResult {
  bool ok = false;
  std::string message;  ///< why it failed: the last line it printed, its signal, or the time limit
};

/// Runs a program, its output appended to `log`; killed with all its children after `limit_s` [s], and when
/// this process dies. Thread-safe.
ProcessResult run_process(const std::vector<std::string>& command, const std::filesystem::path& log,
                          double limit_s);

/// Of what a process printed; empty when it printed nothing.
std::string last_line(const std::filesystem::path& log);

/// This program's own file.
std::filesystem::path own_executable();

}  // namespace uniquadric
