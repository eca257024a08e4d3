// What other programs wrote: looked at, and brought into this program's layout.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <iostream>

#include "core/base/apart.h"
#include "core/base/error.h"
#include "core/base/files.h"
#include "core/import/result.h"
#include "core/import/tum_result.h"
#include "core/sequence/calibration.h"
#include "harness/commands/commands.h"
#include "harness/commands/options.h"
#include "harness/result/check_result.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr int kNotAsExpected = 1;

std::vector<std::string> foreign_layouts() {
  std::vector<std::string> layouts = result_layouts();
  std::erase(layouts, "native");
  return layouts;
}

void convert_result(const std::string& layout, const fs::path& source, const fs::path& sequence_folder,
                    bool force, const fs::path& out) {
  if (sequence_folder.empty() && layout != "tum")
    throw InputError(
        fmt::format("--sequence is required: a {} result has frames' numbers and no stamps", layout));
  require_apart(out, {source, sequence_folder});
  Tracks tracks;
  if (sequence_folder.empty()) {
    tracks = read_tum_result(source);
  } else {
    const Sequence sequence = open_sequence(sequence_folder);
    tracks = read_result(source, layout, sequence);
    tracks.calibration = sequence.camera;
  }
  PendingFolder pending(out, "estimate", force);
  write_estimate(pending.path(), tracks);
  if (tracks.calibration) write_camera_yaml(pending.path() / "camera.yaml", *tracks.calibration);
  pending.commit();
}

}  // namespace

void add_check_result(CLI::App& app, Common& common) {
  auto* sub =
      subcommand(app, "check-result", "what a result holds, what is scored, what looks wrong", common);
  static std::string folder, sequence, truth;
  sub->add_option("FOLDER", folder, "estimate folder that a program wrote")->required();
  sub->add_option("--sequence", sequence, "sequence folder: are the poses at its frames?");
  sub->add_option("--truth", truth, "truth folder: do units, sizes and conventions fit?");
  sub->footer("exit code: 0 nothing looks wrong, 1 something does, 2 it cannot be read");
  sub->callback([&common] {
    const ResultCheck check = check_result(folder, sequence, truth);
    std::cout << check.text;
    for (const std::string& suspicion : check.suspicions) std::cout << "suspicious: " << suspicion << '\n';
    std::cout << fmt::format("{} suspicions\n", check.suspicions.size());
    if (!check.suspicions.empty()) common.exit_code = kNotAsExpected;
  });
}

void add_convert_result(CLI::App& app, Common& common) {
  auto* sub = subcommand(app, "convert-result", "another program's result -> an estimate folder", common);
  static std::string layout, source, out, sequence;
  sub->add_option("LAYOUT", layout, fmt::format("of SRC: {}", fmt::join(foreign_layouts(), ", ")))
      ->required()
      ->check(CLI::IsMember(foreign_layouts()));
  sub->add_option("SRC", source, "file or folder that the program wrote")->required();
  sub->add_option("OUT", out, "folder for the estimate")->required();
  sub->add_option("--sequence", sequence, "sequence folder whose frames the result is about; tum: optional");
  add_force(sub, common);
  sub->callback([&common] { convert_result(layout, source, sequence, common.force, out); });
}

}  // namespace uniquadric
