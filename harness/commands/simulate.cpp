#include "harness/commands/commands.h"

#include <CLI/CLI.hpp>
#include <map>

#include "core/base/apart.h"
#include "core/base/files.h"
#include "harness/bench/keys.h"
#include "harness/commands/options.h"
#include "simulator/preview.h"
#include "simulator/scene/noise_scale.h"
#include "simulator/scene/scene.h"
#include "simulator/simulate.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

// What a report shows of a LiDAR that took the paper's way, to outlive the sequence.
void keep_lidar_routes(const fs::path& data, const fs::path& timing, const fs::path& folder,
                       const std::string& key) {
  fs::create_directories(folder);
  duplicate_file(data / "truth/lidar_comparison.csv", folder / "comparison.csv");
  duplicate_file(data / "truth/lidar_errors.csv", folder / "errors.csv");
  if (!timing.empty()) duplicate_file(timing, folder / "timing.csv");
  if (!key.empty()) record_key(folder, key);
}

constexpr const char* kSet = "a value in place of the scene file's, as lidar.method=embree";

}  // namespace

void add_simulate(CLI::App& app, Common& common) {
  auto* sub = subcommand(app, "simulate", "scene file -> sequence with exact ground truth", common);
  static std::string scene, out, routes;
  static SimulateOptions options;
  static std::int64_t frames = 0;
  static std::string gl = "auto";
  static const std::map<std::string, GlLibrary> libraries{
      {"auto", GlLibrary::automatic}, {"osmesa", GlLibrary::osmesa}, {"egl", GlLibrary::egl}};
  static double noise_scale = 1;
  static std::vector<std::string> set;
  sub->add_option("SCENE", scene, "scene file (YAML)")->required();
  sub->add_option("OUT", out, "folder for sequence/ and truth/")->required();
  sub->add_option("--seed", options.seed, "of all noise")->check(whole_number());
  sub->add_option("--noise-scale", noise_scale, "of the amplitudes of all noise")
      ->check(at_least_0())
      ->check(CLI::Range(0.0, kMostNoiseScale));
  add_set(sub, set, kSet);
  auto* count =
      sub->add_option("--frames", frames, "instead of the scene's number")->check(whole_number(1, kMaxCount));
  sub->add_option(
         "--gl", gl,
         "what draws: osmesa, egl (without a screen; a graphics card's bytes are its own), or auto: osmesa "
         "where its library is installed, else egl")
      ->check(CLI::IsMember({"auto", "osmesa", "egl"}));
  sub->add_option("--timing", options.timing, "file for what each stage took (CSV)");
  sub->add_option("--routes", routes, "folder for the LiDAR's way against Embree (method depth_octree)");
  add_stage_options(sub, common);
  sub->callback([&common, count] {
    options.gl = libraries.at(gl);
    options.threads = common.threads;
    options.quiet = common.quiet;
    options.force = common.force;
    if (count->count() > 0) options.frames = frames;
    require_apart(out, {scene});
    require_apart(options.timing, {scene});
    require_apart(routes, {scene});
    require_replaceable_file(options.timing, common.force, {"table of stage times", "stage,count,"});
    Scene loaded = load_scene(scene, parse_overrides(set));
    scale_noise(loaded, noise_scale);
    make_stage(common, out, [&] {
      simulate(loaded, options, out);
      if (!routes.empty()) keep_lidar_routes(out, options.timing, routes, common.key);
    });
  });
}

void add_preview(CLI::App& app, Common& common) {
  auto* sub = subcommand(app, "preview", "scene file -> a picture of some of its frames", common);
  static std::string scene, out;
  static PreviewOptions options;
  static std::vector<std::string> set;
  sub->add_option("SCENE", scene, "scene file (YAML)")->required();
  sub->add_option("OUT", out, "the picture (.png, .jpg, .jpeg)")->required();
  sub->add_option("--frames", options.frames, "how many, side by side")->check(whole_number(1, 100));
  add_set(sub, set, kSet);
  sub->add_option("--width", options.width_px, "of the picture, in pixels")->check(whole_number(1, 16384));
  add_force(sub, common)->description("replace a picture of the same kind, whoever made it; no other file");
  sub->callback([&common] {
    require_apart(out, {scene});
    require_replaceable_file(out, common.force, picture_kind(out));
    require_picture_ending(out);
    write_preview(load_scene(scene, parse_overrides(set)), options, out);
  });
}

}  // namespace uniquadric
