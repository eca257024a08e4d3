#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/base/resource_usage.h"

namespace uniquadric {

struct TreeCommand {
  std::vector<std::string> arguments;    ///< the program first, looked for in PATH of `environment`
  std::vector<std::string> environment;  ///< NAME=VALUE, nothing else
  std::filesystem::path folder;          ///< that it runs in
};

/// What becomes of the text that the tree prints.
enum class Printing { passed_on, hidden };

/// Of all processes of the tree together.
struct TreeLimits {
  double time_s = 3600;
  double memory_mb = 8000;  ///< resident, 10^6 bytes
  double output_mb = 2000;  ///< of all files below `output`, 10^6 bytes; of any single file wherever it is
  std::filesystem::path output;
};

struct TreeResult {
  std::string failure;  ///< empty: its exit code was 0
  ResourceUsage usage;
};

/// Runs a program and everything that it starts until the program itself has ended or the tree has come to a
/// limit; then no process of the tree is left, also of those that left their group or session. The same holds
/// when this process ends first, whatever ends it. What the tree prints goes to this process' standard error,
/// up to 16 MiB; standard input is empty. Memory is looked at every 20 ms, files every 200 ms.
TreeResult run_tree(const TreeCommand& command, const TreeLimits& limits,
                    Printing printing = Printing::passed_on);

}  // namespace uniquadric
