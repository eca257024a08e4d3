#include "harness/bench/config.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <set>

#include "core/base/config.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/base/warning.h"
#include "evaluation/association/object_choice.h"
#include "evaluation/results/results.h"
#include "harness/external/external_variant.h"
#include "simulator/families/family.h"
#include "simulator/scene/noise_scale.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr int kMostOfFamily = 100'000;

// The file that `node` names, relative to the bench's.
BenchItem read_file(const ConfigNode& root, const ConfigNode& node) {
  const auto path = root.file().parent_path() / node.as<std::string>();
  std::error_code too_long;
  if (!std::filesystem::is_regular_file(path, too_long))
    node.fail(fmt::format("file {} does not exist", path.string()));
  const std::string name = path.stem().string();
  if (!is_plain_name(name))
    node.fail("a comma, quote or backslash in a file's name cannot stand in the results");
  return {name, path.lexically_normal()};
}

std::vector<std::uint64_t> read_seeds(const ConfigNode& node) {
  std::vector<std::uint64_t> seeds;
  std::set<std::uint64_t> seen;
  for (const ConfigNode& item : node.at("seeds").items()) {
    seeds.push_back(item.as<std::uint64_t>());
    if (!seen.insert(seeds.back()).second) item.fail(fmt::format("{} stands twice", seeds.back()));
  }
  if (seeds.empty()) node.at("seeds").fail("expected at least one");
  return seeds;
}

// The folder of a recording, named by its own name. It need not exist where it is `optional`.
BenchItem read_recording(const ConfigNode& root, const ConfigNode& node, bool is_optional) {
  const fs::path path = (root.file().parent_path() / node.as<std::string>()).lexically_normal();
  const fs::path folder = path.has_filename() ? path : path.parent_path();
  std::error_code too_long;
  const bool is_there = fs::is_directory(folder, too_long);
  if (!is_there && !is_optional) node.fail(fmt::format("folder {} does not exist", folder.string()));
  if (is_there && !fs::exists(folder / "sequence.yaml") && !fs::exists(folder / "sequence/sequence.yaml"))
    node.fail(fmt::format("folder {} holds no sequence; `uniquadric import` makes one of a recording",
                          folder.string()));
  return {folder.filename().string(), folder};
}

// KIND:FILE, the file relative to the bench's.
std::string read_prompt(const ConfigNode& root, const ConfigNode& node) {
  const std::string text = node.as<std::string>();
  const std::size_t colon = text.find(':');
  const std::string kind = text.substr(0, colon);
  if (colon == std::string::npos || (kind != "boxes" && kind != "points"))
    node.fail("expected boxes:FILE or points:FILE");
  const fs::path file = (root.file().parent_path() / text.substr(colon + 1)).lexically_normal();
  std::error_code too_long;
  if (!fs::exists(file, too_long)) node.fail(fmt::format("{} does not exist", file.string()));
  return kind + ":" + file.string();
}

std::vector<std::string> read_judging(const ConfigNode& node) {
  std::vector<std::string> options;
  if (const auto objects = node.find("objects")) {
    try {
      parse_object_choice(objects->as<std::string>());
    } catch (const InputError& error) {
      node.fail(error.what());
    }
    options = {"--objects", objects->as<std::string>()};
  }
  if (node.has("unlabelled"))
    options.insert(options.end(),
                   {"--unlabelled", node.choice("unlabelled", {"auto", "ignore", "false"}, "auto")});
  return options;
}

bool is_there(const BenchScene& item) {
  return item.drawn_from || fs::exists(item.path);
}

std::vector<ConfigOverride> read_set(const ConfigNode& node, const std::string& key = "set") {
  std::vector<ConfigOverride> overrides;
  if (const auto set = node.find(key)) {
    for (const auto& [name, value] : set->entries())
      overrides.push_back({name, value.yaml(),
                           fmt::format("{}:{}: {}", value.file().string(), value.line(), set->key_path())});
    set->refuse_unknown_keys();  // that stand twice
  }
  return overrides;
}

// What the maps of all kinds of scenes may have.
void read_common(const ConfigNode& node, BenchScene& scene) {
  scene.judging = read_judging(node);
  if (node.has("seeds")) scene.seeds = read_seeds(node);
  if (scene.is_recording) return;
  scene.noise_scale = node.get<double>("noise_scale", 1);
  if (!(scene.noise_scale >= 0 && scene.noise_scale <= kMostNoiseScale))
    node.at("noise_scale").fail(fmt::format("expected 0 to {}", kMostNoiseScale));
}

// A scene for each of `count` seeds of its own.
std::vector<BenchScene> read_family(const ConfigNode& node, const std::vector<std::uint64_t>& seeds) {
  FamilyRequest request{node.choice("family", family_names(), ""), node.get<std::uint64_t>("first_seed", 1),
                        read_set(node)};
  const int count = node.get<int>("count", 1);
  if (count < 1 || count > kMostOfFamily)
    node.at("count").fail(fmt::format("expected 1 to {}", kMostOfFamily));
  if (request.seed > std::numeric_limits<std::uint64_t>::max() - static_cast<std::uint64_t>(count - 1))
    node.at("first_seed").fail(fmt::format("{} seeds from there on leave 64 bits", count));
  check_request(request);
  const std::string name = node.name("name", request.family);
  BenchScene common;
  common.seeds = seeds;
  common.set = read_set(node, "scene_set");
  common.where = node.place();
  read_common(node, common);
  node.refuse_unknown_keys();
  std::vector<BenchScene> scenes(static_cast<std::size_t>(count), common);
  for (BenchScene& scene : scenes) {
    scene.name = fmt::format("{}_{}", name, request.seed);
    scene.drawn_from = request;
    ++request.seed;
  }
  return scenes;
}

BenchScene scene_of_file(const ConfigNode& root, const ConfigNode& file,
                         const std::vector<std::uint64_t>& seeds) {
  BenchScene scene{read_file(root, file)};
  scene.seeds = seeds;
  return scene;
}

BenchScene read_item_of_scene(const ConfigNode& root, const ConfigNode& node,
                              const std::vector<std::uint64_t>& seeds) {
  if (const auto recording = node.find("recording")) {
    BenchScene scene{read_recording(root, *recording, node.get<bool>("optional", false)), true};
    scene.seeds = {0};
    return scene;
  }
  if (!node.has("scene")) node.fail("expected a key scene, recording or family");
  BenchScene scene = scene_of_file(root, node.at("scene"), seeds);
  scene.set = read_set(node);
  return scene;
}

// `name`, or else `fallback`, which names a folder of the results.
std::string plain_name(const ConfigNode& node, const std::string& fallback) {
  std::string name = node.name("name", fallback);
  if (!is_plain_name(name))
    node.fail(fmt::format("'{}' cannot be a name in the results; give another `name`", name));
  return name;
}

// A path, or a map with what is other than usual.
std::vector<BenchScene> read_scenes(const ConfigNode& root, const ConfigNode& node,
                                    const std::vector<std::uint64_t>& seeds) {
  if (!node.is_map()) return {scene_of_file(root, node, seeds)};
  if (node.has("family")) return read_family(node, seeds);
  BenchScene scene = read_item_of_scene(root, node, seeds);
  scene.name = plain_name(node, scene.name);
  if (const auto prompt = node.find("prompt"); prompt && is_there(scene))
    scene.prompt = read_prompt(root, *prompt);
  read_common(node, scene);
  node.refuse_unknown_keys();
  return {scene};
}

// A path, or a map with values in place of the file's and with a name of its own, which `run.yaml` has too.
BenchVariant read_variant(const ConfigNode& root, const ConfigNode& node) {
  BenchVariant variant{read_file(root, node.is_map() ? node.at("variant") : node)};
  if (node.is_map()) {
    variant.set = read_set(node);
    variant.name = plain_name(node, variant.name);
    node.refuse_unknown_keys();
  }
  if (variant.name.find(kOutputMark) != std::string::npos)
    node.fail(fmt::format("'{}': {}", variant.name, kOutputMarkTaken));
  if (!variant.set.empty()) {
    node.at("name");
    if (is_external(variant.path)) node.at("set").fail("a variant with a command has no values to set");
    variant.set.push_back({"name", yaml_quoted(variant.name), node.place()});
  }
  return variant;
}

// Recordings have the seed 0, and any item may name its own.
bool all_have_seeds(const ConfigNode& root) {
  return std::ranges::all_of(root.at("scenes").items(), [](const ConfigNode& node) {
    return node.is_map() && (node.has("recording") || node.has("seeds"));
  });
}

// The list at `key`, each node some items by `read`; their names are told apart.
template <typename Read>
auto read_items(const ConfigNode& root, const std::string& key, const Read& read) {
  decltype(read(root)) items;
  std::set<std::string> names;
  for (const ConfigNode& node : root.at(key).items())
    for (auto& item : read(node)) {
      if (!names.insert(item.name).second) node.fail(fmt::format("the name '{}' stands twice", item.name));
      items.push_back(std::move(item));
    }
  if (items.empty()) root.at(key).fail("expected at least one");
  return items;
}

// Optional recordings whose folders do not exist.
void leave_out_absent(const ConfigNode& root, std::vector<BenchScene>& scenes) {
  for (const BenchScene& scene : scenes)
    if (!is_there(scene))
      warn(fmt::format("{}: recording {} is not there and is left out", root.file().string(), scene.name));
  std::erase_if(scenes, std::not_fn(is_there));
  if (scenes.empty()) root.at("scenes").fail("none of them is there");
}

std::string relative_path(const fs::path& path, const fs::path& folder) {
  return yaml_quoted(fs::proximate(path, folder).generic_string());
}

std::string prompt_entry(const std::string& prompt, const fs::path& folder) {
  const std::size_t colon = prompt.find(':');
  return yaml_quoted(prompt.substr(0, colon + 1) +
                     fs::proximate(prompt.substr(colon + 1), folder).generic_string());
}

// `name` is said anyway, and so not one of them.
std::string set_entry(const std::vector<ConfigOverride>& set) {
  std::vector<std::string> values;
  for (const ConfigOverride& value : set)
    if (value.key != "name") values.push_back(fmt::format("{}: {}", yaml_quoted(value.key), value.value));
  return values.empty() ? "" : fmt::format(", set: {{{}}}", fmt::join(values, ", "));
}

std::string scene_entry(const BenchScene& scene, const std::vector<std::uint64_t>& seeds,
                        const fs::path& folder) {
  std::string text = fmt::format("{{{}: {}, name: {}", scene.is_recording ? "recording" : "scene",
                                 relative_path(scene.path, folder), yaml_quoted(scene.name));
  text += set_entry(scene.set);
  if (!scene.prompt.empty()) text += fmt::format(", prompt: {}", prompt_entry(scene.prompt, folder));
  if (scene.noise_scale != 1) text += fmt::format(", noise_scale: {}", scene.noise_scale);
  if (scene.seeds != seeds) text += fmt::format(", seeds: [{}]", fmt::join(scene.seeds, ", "));
  for (std::size_t i = 0; i + 1 < scene.judging.size(); i += 2)  // --objects X --unlabelled Y
    text += fmt::format(", {}: {}", scene.judging[i].substr(2), yaml_quoted(scene.judging[i + 1]));
  return text + "}";
}

std::string variant_entry(const BenchVariant& variant, const fs::path& folder) {
  return fmt::format("{{variant: {}, name: {}{}}}", relative_path(variant.path, folder),
                     yaml_quoted(variant.name), set_entry(variant.set));
}

}  // namespace

BenchConfig load_bench_config(const std::filesystem::path& path) {
  const ConfigNode root = ConfigNode::load(path);
  BenchConfig config;
  config.name = root.name("name", path.stem().string());
  if (root.has("seeds") || !all_have_seeds(root)) config.seeds = read_seeds(root);
  config.scenes = read_items(root, "scenes",
                             [&](const ConfigNode& node) { return read_scenes(root, node, config.seeds); });
  leave_out_absent(root, config.scenes);
  config.variants = read_items(root, "variants",
                               [&](const ConfigNode& node) { return std::vector{read_variant(root, node)}; });
  if (const auto frames = root.find("frames")) {
    config.frames = frames->as<std::int64_t>();
    if (*config.frames < 1) frames->fail("expected at least 1");
  }
  config.keep_sequences = root.get<bool>("keep_sequences", config.keep_sequences);
  config.stage_limit_s = root.positive("stage_limit_s", config.stage_limit_s);
  config.overlays = root.get<int>("overlays", config.overlays);
  if (config.overlays < 0) root.at("overlays").fail("expected at least 0");
  root.refuse_unknown_keys();
  return config;
}

std::string bench_yaml(const BenchConfig& config, const fs::path& folder) {
  std::string text = fmt::format("name: {}\nscenes:\n", yaml_quoted(config.name));
  for (const BenchScene& scene : config.scenes)
    text += fmt::format("  - {}\n", scene_entry(scene, config.seeds, folder));
  text += "variants:\n";
  for (const BenchVariant& variant : config.variants)
    text += fmt::format("  - {}\n", variant_entry(variant, folder));
  if (!config.seeds.empty()) text += fmt::format("seeds: [{}]\n", fmt::join(config.seeds, ", "));
  if (config.frames) text += fmt::format("frames: {}\n", *config.frames);
  return text + fmt::format("overlays: {}\nstage_limit_s: {}\n", config.overlays, config.stage_limit_s);
}

}  // namespace uniquadric
