#include "harness/commands/commands.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <iostream>

#include "harness/check.h"
#include "harness/commands/options.h"
#include "harness/info.h"
#include "harness/perception_info.h"

namespace uniquadric {

void add_info(CLI::App& app, Common& common) {
  auto* sub = subcommand(app, "info", "what a folder or file is", common);
  static std::string path;
  static bool check = false, deep = false;
  sub->add_option("PATH", path,
                  "sequence, truth, perception, estimate, results; scene, variant, bench or .tum file")
      ->required();
  sub->add_flag(
      "--check", check,
      "verify a sequence, a truth (counts, stamps, images, calibration, hashes) or a kept perception");
  sub->add_flag("--deep", deep,
                "with --check: also whether a sequence's poses, depth, clocks, IMU and scans fit each other")
      ->needs("--check");
  sub->callback([&common] {
    std::cout << describe(path);
    if (!check) return;
    std::vector<std::string> problems = is_perception(path) ? check_perception(path) : check_sequence(path);
    if (deep && !is_perception(path))
      for (std::string& suspicion : check_plausibility(path)) problems.push_back(std::move(suspicion));
    for (const std::string& problem : problems) std::cout << "problem: " << problem << '\n';
    std::cout << fmt::format("{} problems\n", problems.size());
    if (!problems.empty()) common.exit_code = kBadInput;
  });
}

}  // namespace uniquadric
