#include "harness/commands/commands.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>

#include "core/base/apart.h"
#include "core/base/error.h"
#include "evaluation/run_record.h"
#include "harness/commands/options.h"
#include "harness/export/export.h"

namespace uniquadric {

void add_export(CLI::App& app, Common& common) {
  auto* sub = subcommand(app, "export", "a sequence -> another tool's format", common);
  static std::string format, sequence, out, truth, estimate;
  static ExportOptions options;
  sub->add_option("FORMAT", format, fmt::format("{}", fmt::join(export_formats(), ", ")))
      ->required()
      ->check(CLI::IsMember(export_formats()));
  sub->add_option("SEQUENCE", sequence, "sequence folder")->required();
  sub->add_option("OUT", out, "folder for the export")->required();
  sub->add_option("--truth", truth, "truth folder; default: the one beside the sequence");
  sub->add_option("--estimate", estimate, "mcap: estimate folder, exported beside the truth");
  static const CLI::Option* frames =
      sub->add_option("--frame-stride", options.frame_stride, "ply: every which frame")
          ->check(whole_number(1, kMaxCount));
  static const CLI::Option* pixels =
      sub->add_option("--pixel-stride", options.pixel_stride, "ply: every which pixel")
          ->check(whole_number(1, kMaxCount));
  add_force(sub, common);
  sub->callback([&common] {
    if (format != "ply" && frames->count() + pixels->count() > 0)
      throw InputError(fmt::format("{} has no strides: those are of ply", format));
    options.truth = truth;
    options.estimate = estimate;
    options.quiet = common.quiet;
    options.force = common.force;
    require_apart(out, {sequence, truth, estimate});
    if (!estimate.empty()) require_one_scene({sequence, scene_of(sequence)}, {estimate, scene_of(estimate)});
    export_sequence(format, sequence, out, options);
  });
}

}  // namespace uniquadric
