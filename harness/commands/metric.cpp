#include "harness/commands/commands.h"

#include <CLI/CLI.hpp>
#include <iostream>

#include "evaluation/metric.h"
#include "harness/commands/options.h"

namespace uniquadric {

void add_metric(CLI::App& app, Common& common) {
  auto* sub = subcommand(app, "metric", "one figure per JSON line: stdin -> stdout", common);
  static std::string kind;
  static MetricOptions options;
  sub->add_option("KIND", kind, "iou3d, iou2d, project or pose")
      ->required()
      ->check(CLI::IsMember({"iou3d", "iou2d", "project", "pose"}));
  sub->add_option("--method", options.method, "of iou3d")->check(CLI::IsMember({"exact", "monte-carlo"}));
  sub->add_option("--samples", options.samples, "of monte-carlo")->check(whole_number(1, kMaxCount));
  sub->add_option("--seed", options.seed, "of monte-carlo")->check(whole_number());
  sub->callback([&common] { common.exit_code = run_metric(kind, options, std::cin, std::cout); });
}

}  // namespace uniquadric
