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
  static bool check = false;
  sub->add_option("PATH", path,
                  "sequence, truth, perception, estimate, results; scene, variant, bench or .tum file")
      ->required();
  sub->add_flag(
      "--check", check,
      "verify a sequence, a truth (counts, stamps, images, calibration, hashes) or a kept perception");
  sub->callback([&common] {
    std::cout << describe(path);
    if (!check) return;
    const std::vector<std::string> problems =
        is_perception(path) ? check_perception(path) : check_sequence(path);
    for (const std::string& problem : problems) std::cout << "problem: " << problem << '\n';
    std::cout << fmt::format("{} problems\n", problems.size());
    if (!problems.empty()) common.exit_code = kBadInput;
  });
}

}  // namespace uniquadric
