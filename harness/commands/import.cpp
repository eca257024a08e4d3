#include "harness/commands/commands.h"

#include <CLI/CLI.hpp>

#include "core/base/apart.h"
#include "core/import/kitti.h"
#include "core/import/tum.h"
#include "harness/commands/options.h"

namespace uniquadric {
namespace {

void add_import_kitti(CLI::App& app, Common& common) {
  auto* sub = subcommand(app, "kitti-tracking", "a recording of KITTI's tracking benchmark", common);
  static std::string source, out;
  static ImportKittiOptions options;
  sub->add_option("SRC", source, "folder with image_02/ or velodyne/, calib/, ...")->required();
  sub->add_option("OUT", out, "folder for sequence/ and, of labels, truth/")->required();
  sub->add_option("--drive", options.drive, "which recording (0000); default: the only one");
  add_force(sub, common);
  sub->callback([&common] {
    options.quiet = common.quiet;
    options.force = common.force;
    require_apart(out, {source});
    import_kitti_tracking(source, options, out);
  });
}

}  // namespace

void add_import(CLI::App& app, Common& common) {
  auto* sub = app.add_subcommand("import", "a real recording -> sequence");
  sub->require_subcommand(1);
  add_import_kitti(*sub, common);
  auto* tum = subcommand(*sub, "tum", "a TUM RGB-D recording", common);
  static std::string source, out, camera;
  static ImportTumOptions options;
  tum->add_option("SRC", source, "folder with rgb.txt, depth.txt")->required();
  tum->add_option("OUT", out, "sequence folder")->required();
  tum->add_option("--camera", camera, "calibration; default: SRC/camera.yaml");
  add_force(tum, common);
  tum->callback([&common] {
    options.camera = camera;
    options.quiet = common.quiet;
    options.force = common.force;
    require_apart(out, {source, camera});
    import_tum(source, options, out);
  });
}

}  // namespace uniquadric
