#include "harness/commands/commands.h"

#include <CLI/CLI.hpp>

#include "core/base/apart.h"
#include "evaluation/report/overlay.h"
#include "harness/commands/options.h"

namespace uniquadric {

void add_overlay(CLI::App& app, Common& common) {
  auto* sub = subcommand(app, "overlay", "frames with masks and outlines drawn in", common);
  sub->footer(
      "green: the true bodies, ellipsoids and cylinders by their outlines, all others by their tight boxes,\n"
      "and the ellipsoids within where ellipsoids alone were estimated; orange: outlines of the estimated\n"
      "bodies, ellipsoids with their rotated rectangle; yellow: edges of the estimated boxes; tinted: masks");
  static std::string sequence, estimate_folder, out, truth, color;
  static int count = 16;
  sub->add_option("SEQUENCE", sequence, "sequence folder")->required();
  sub->add_option("ESTIMATE", estimate_folder, "estimate folder")->required();
  sub->add_option("OUT", out, "folder for the pictures and sheet.jpg")->required();
  sub->add_option("--truth", truth, "truth folder, to draw true outlines too");
  sub->add_option("--colour", color,
                  "of the estimates, as #0072b2; the truth is white then, as in the report");
  sub->add_option("--count", count, "frames, evenly spaced")->check(whole_number(1, kMaxCount));
  add_stage_options(sub, common);
  sub->callback([&common] {
    require_apart(out, {sequence, truth, estimate_folder});
    make_stage(common, out,
               [&] { write_overlays(sequence, truth, estimate_folder, out, count, common.force, color); });
  });
}

}  // namespace uniquadric
