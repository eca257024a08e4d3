#include "harness/commands/commands.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <iostream>

#include "core/base/apart.h"
#include "evaluation/report/report.h"
#include "harness/bench/bench.h"
#include "harness/bench/plan.h"
#include "harness/commands/options.h"

namespace uniquadric {

void add_bench(CLI::App& app, Common& common) {
  auto* sub = subcommand(app, "bench", "scenes x variants x seeds -> report; resumes", common);
  static std::string config, out;
  static BenchOptions options;
  sub->add_option("BENCH", config, "bench file (YAML)")->required();
  sub->add_option("OUT", out, "results folder")->required();
  sub->add_option("--jobs", options.jobs, "stages at once; default: as many as there are cores")
      ->check(whole_number(1, kMaxCount));
  sub->add_flag("--keep", options.keep_sequences, "keep the sequences");
  static bool plan = false;
  sub->add_flag("--plan", plan,
                "run nothing: print the stages' commands as JSON lines, for a workflow engine");
  sub->add_flag("--collect", options.collect, "run no stage: write the report of what is in OUT");
  sub->callback([&common] {
    options.quiet = common.quiet;
    options.command = common.command;
    require_apart(out, {config});
    if (plan) {
      const BenchPlan planned = plan_bench(config, out, common.quiet);
      write_scenes(planned);
      return print_plan(planned, config, std::cout);
    }
    const int failed = bench(config, out, options);
    std::cout << summary_table(out) << "report: " << out << "/report.html\n";
    if (failed > 0) {
      std::cerr << fmt::format("uniquadric: {} {} failed; see {}/cells.csv\n", failed,
                               failed == 1 ? "cell" : "cells", out);
      common.exit_code = kBadInput;
    }
  });
}

}  // namespace uniquadric
