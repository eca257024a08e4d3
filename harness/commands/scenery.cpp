#include <CLI/CLI.hpp>

#include "core/base/apart.h"
#include "evaluation/report/scenery.h"
#include "harness/commands/commands.h"
#include "harness/commands/options.h"

namespace uniquadric {

void add_scenery(CLI::App& app, Common& common) {
  auto* sub = subcommand(app, "scenery",
                         "what the report shows of a sequence: small frames, true meshes, a cloud", common);
  static std::string sequence, out, truth;
  static SceneryOptions options;
  sub->add_option("SEQUENCE", sequence, "sequence folder")->required();
  sub->add_option("OUT", out, "folder for the frames and scenery.json")->required();
  sub->add_option("--truth", truth, "truth folder, for meshes and cloud");
  sub->add_option("--frames", options.frames, "frames, evenly spaced")->check(whole_number(1, kMaxCount));
  add_stage_options(sub, common);
  sub->callback([&common] {
    require_apart(out, {sequence, truth});
    make_stage(common, out, [&] { write_scenery(sequence, truth, out, options, common.force); });
  });
}

}  // namespace uniquadric
