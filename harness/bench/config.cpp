#include "harness/bench/config.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <set>

#include "core/base/config.h"
#include "core/base/text.h"

namespace uniquadric {
namespace {

std::vector<BenchItem> read_items(const ConfigNode& root, const std::string& key) {
  std::vector<BenchItem> items;
  std::set<std::string> names;
  for (const ConfigNode& node : root.at(key).items()) {
    const auto path = root.file().parent_path() / node.as<std::string>();
    if (!std::filesystem::is_regular_file(path))
      node.fail(fmt::format("file {} does not exist", path.string()));
    const std::string name = path.stem().string();
    if (!is_plain_name(name))
      node.fail("a comma, quote or backslash in a file's name cannot stand in the results");
    if (!names.insert(name).second) node.fail(fmt::format("the name '{}' stands twice", name));
    items.push_back({name, path.lexically_normal()});
  }
  if (items.empty()) root.at(key).fail("expected at least one");
  return items;
}

std::vector<std::uint64_t> read_seeds(const ConfigNode& root) {
  std::vector<std::uint64_t> seeds;
  std::set<std::uint64_t> seen;
  for (const ConfigNode& node : root.at("seeds").items()) {
    seeds.push_back(node.as<std::uint64_t>());
    if (!seen.insert(seeds.back()).second) node.fail(fmt::format("{} stands twice", seeds.back()));
  }
  if (seeds.empty()) root.at("seeds").fail("expected at least one");
  return seeds;
}

std::vector<std::string> quoted_names(const std::vector<BenchItem>& items) {
  std::vector<std::string> result;
  for (const auto& item : items) result.push_back(yaml_quoted(item.name));
  return result;
}

}  // namespace

BenchConfig load_bench_config(const std::filesystem::path& path) {
  const ConfigNode root = ConfigNode::load(path);
  BenchConfig config;
  config.name = root.name("name", path.stem().string());
  config.scenes = read_items(root, "scenes");
  config.variants = read_items(root, "variants");
  config.seeds = read_seeds(root);
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

std::string bench_yaml(const BenchConfig& config) {
  std::string text =
      fmt::format("name: {}\nscenes: [{}]\nvariants: [{}]\nseeds: [{}]\n", yaml_quoted(config.name),
                  fmt::join(quoted_names(config.scenes), ", "),
                  fmt::join(quoted_names(config.variants), ", "), fmt::join(config.seeds, ", "));
  if (config.frames) text += fmt::format("frames: {}\n", *config.frames);
  return text;
}

}  // namespace uniquadric
