#include <CLI/CLI.hpp>
#include <algorithm>
#include <string_view>

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/hash.h"
#include "core/base/read_file.h"
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

constexpr std::string_view kBody = ", body ";

std::string note_of(std::string_view body) {
  return std::string(kBody) + Hash().add(body).hex() + '.';
}

// With the hash of what follows the first line in that line. A bench's scenes have none: theirs are frozen.
std::string with_body_hash(const std::string& scene) {
  const std::size_t end = scene.find('\n');
  return scene.substr(0, end - 1) + note_of(std::string_view(scene).substr(end + 1)) + scene.substr(end);
}

// Only what stands there as it was drawn may be replaced.
void require_unedited(const fs::path& scene) {
  if (!fs::exists(scene)) return;
  const std::string text = read_file(scene, kYamlFile);
  const std::string head = text.substr(0, text.find('\n'));
  if (text.empty()) return;
  if (head.find(kBody) == head.npos)
    throw InputError(scene, "does not say how it was drawn, so --force does not replace it");
  if (!head.ends_with(note_of(std::string_view(text).substr(std::min(head.size() + 1, text.size())))))
    throw InputError(scene, "was edited since it was drawn, so --force does not replace it");
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
  sub->add_option("--seed", request.seed, "of all that is drawn; default: 0")->check(whole_number());
  add_set(sub, set,
          "difficulty (0 to 1), frames, count (of objects), realism, meshes (a folder), lidar (of a street)");
  add_force(sub, common)->description("replace a scene that generate wrote, unless it was edited");
  sub->callback([&common] {
    require_replaceable_file(out, common.force, {"scene that generate wrote", kSceneHead});
    require_scene_ending(out);
    require_unedited(out);
    request.set = parse_overrides(set);
    write_text(out, with_body_hash(generate_scene(request)));
  });
}

}  // namespace uniquadric
