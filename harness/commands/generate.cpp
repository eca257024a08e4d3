#include <CLI/CLI.hpp>

#include "core/base/error.h"
#include "core/base/files.h"
#include "harness/commands/commands.h"
#include "harness/commands/options.h"
#include "simulator/families/family.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

void require_scene_ending(const fs::path& scene) {
  const fs::path ending = scene.extension();
  if (ending != ".yaml" && ending != ".yml") throw InputError(scene, "a scene's name ends in .yaml or .yml");
}

}  // namespace

void add_generate(CLI::App& app, Common& common) {
  auto* sub = app.add_subcommand("generate", "family of scenes -> a scene file, drawn at random");
  static FamilyRequest request;
  static std::string out;
  static std::vector<std::string> set;
  sub->add_option("FAMILY", request.family, "what is drawn")
      ->required()
      ->check(CLI::IsMember(family_names()));
  sub->add_option("OUT", out, "the scene file (YAML)")->required();
  sub->add_option("--seed", request.seed, "of all that is drawn")->check(whole_number());
  add_set(sub, set,
          "difficulty (0 to 1), frames, count (of objects), realism, meshes (a folder), lidar (of a street)");
  add_force(sub, common)->description("replace a scene that generate wrote");
  sub->callback([&common] {
    require_replaceable_file(out, common.force, {"scene that generate wrote", kSceneHead});
    require_scene_ending(out);
    request.set = parse_overrides(set);
    write_text(out, generate_scene(request));
  });
}

}  // namespace uniquadric
