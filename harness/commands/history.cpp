#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>

#include "core/base/apart.h"
#include "core/base/files.h"
#include "evaluation/report/history.h"
#include "harness/commands/commands.h"
#include "harness/commands/options.h"

namespace uniquadric {

void add_history(CLI::App& app, Common& common) {
  auto* sub =
      subcommand(app, "history", "metrics over several benches, with the gate's verdict on each", common);
  static std::vector<std::filesystem::path> folders;
  static std::string html;
  sub->add_option("RESULTS", folders, "results folders of bench, oldest first")->required();
  sub->add_option("--html", html, "page to write");
  add_force(sub, common)->description("replace the page of --html");
  sub->callback([&common] {
    for (const auto& folder : folders) require_apart(html, {folder});
    require_replaceable_file(html, common.force, {"page of a history", "<!doctype html>"});
    const History made = history(folders);
    if (!html.empty()) write_text(html, made.html);
    std::cout << made.text;
  });
}

}  // namespace uniquadric
