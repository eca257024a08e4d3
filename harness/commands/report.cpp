#include "harness/commands/commands.h"

#include <CLI/CLI.hpp>
#include <iostream>

#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "evaluation/report/report.h"
#include "harness/bench/process.h"
#include "harness/commands/options.h"

namespace uniquadric {

void add_report(CLI::App& app, Common& common) {
  auto* sub = subcommand(app, "report", "results -> report.html, report.md, scores.csv", common);
  static std::string results;
  static ReportExtras extras;
  static bool open = false;
  sub->add_option("RESULTS", results, "results folder of bench")->required();
  sub->add_flag("--latex", extras.latex, "write report.tex there, too: the summary as a table (booktabs)");
  sub->add_flag("--pdf", extras.figures, "write figures/ there, too: every plot as PDF and as SVG");
  sub->add_flag("--open", open, "show it in the desktop's browser");
  sub->callback([] {
    leave_when_interrupted(results + "/scores.csv.partial is left, which the same command replaces");
    write_report(results, extras);
    leave_when_interrupted("");
    std::cout << results << "/report.html\n";
    if (!open) return;
    const ProcessResult shown =
        run_process({"/usr/bin/env", "xdg-open", results + "/report.html"}, "/dev/null", 60);
    if (!shown.ok) throw InputError("the report cannot be shown: " + shown.message);
  });
}

}  // namespace uniquadric
