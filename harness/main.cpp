// The program: builds its subcommands (commands/), runs the one asked for, turns errors into exit codes.
#include <fmt/format.h>
#include <csignal>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <iostream>

#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/version.h"
#include "harness/bench/program.h"
#include "harness/commands/commands.h"
#include "harness/commands/options.h"
#include "harness/fault_line.h"

namespace uniquadric {
namespace {

// In the order of --help.
constexpr void (*kCommands[])(CLI::App&, Common&) = {
    add_generate, add_simulate, add_preview,      add_estimate,       add_perceive,
    add_evaluate, add_bench,    add_report,       add_compare,        add_history,
    add_overlay,  add_scenery,  add_info,         add_metric,         add_trajectory,
    add_import,   add_export,   add_check_result, add_convert_result, add_completion,
};

std::string command_line(int argc, char** argv) {
  std::string text = "uniquadric";
  for (int i = 1; i < argc; ++i) text += std::string(" ") + argv[i];
  return text;
}

int run(int argc, char** argv) {
  CLI::App app("uniquadric: simulate, estimate and evaluate object-level SLAM with moving objects");
  app.set_version_flag("--version", fmt::format("{}\n{}", kProgram, program_source()));
  app.require_subcommand(1);
  Common common;
  common.command = command_line(argc, argv);
  for (const auto add : kCommands) add(app, common);
  if (argc > 1 && argv[1][0] != '-' &&
      app.get_subcommands([&](const CLI::App* sub) { return sub->get_name() == argv[1]; }).empty()) {
    std::cerr << fmt::format("uniquadric: there is no subcommand '{}'; see uniquadric --help\n", argv[1]);
    return kBadInput;
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return app.exit(e);
    std::cerr << "uniquadric: " << e.what() << "; see uniquadric --help\n";
    return kBadInput;
  } catch (const std::filesystem::filesystem_error& e) {
    std::cerr << fmt::format("uniquadric: {}: {}\n", e.path1().string(), e.code().message());
    return kBadInput;
  } catch (const InputError& e) {
    std::cerr << "uniquadric: " << e.what() << '\n';
    return kBadInput;
  } catch (const std::exception& e) {
    std::cerr << "uniquadric: " << fault_line(e) << '\n';
    return kInternalError;
  }
  if (!std::cout.flush()) {
    std::cerr << fmt::format("uniquadric: standard output cannot be written: {}\n", std::strerror(errno));
    return kBadInput;
  }
  return common.exit_code;
}

}  // namespace
}  // namespace uniquadric

int main(int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);  // a file larger than may be is a write that fails, and is said
  uniquadric::say_what_is_left_when_interrupted();
  return uniquadric::run(argc, argv);
}
