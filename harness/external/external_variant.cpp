#include "harness/external/external_variant.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <ranges>

#include "core/base/config.h"
#include "core/base/folder_hashes.h"
#include "core/base/hash.h"
#include "core/base/text.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr int kSchema = 1;
const std::vector<std::string> kLayouts = {"native", "tum", "kitti-tracking", "bop", "euroc",
                                           "rosbag", "vdo"};
const std::vector<std::string> kResults = {"native", "tum", "kitti-tracking", "bop"};

constexpr const char* kNeverMounted[] = {"/", "/proc", "/dev", "/sys", "/run"};

std::vector<std::string> read_texts(const ConfigNode& root, const std::string& key) {
  std::vector<std::string> texts;
  if (const auto list = root.find(key))
    for (const ConfigNode& item : list->items()) texts.push_back(item.as<std::string>());
  return texts;
}

std::vector<fs::path> read_paths(const ConfigNode& root, const std::string& key, const fs::path& folder) {
  std::vector<fs::path> paths;
  if (const auto list = root.find(key))
    for (const ConfigNode& item : list->items()) {
      const fs::path path = (folder / item.as<std::string>()).lexically_normal();
      if (!fs::exists(path)) item.fail(fmt::format("{} does not exist", path.string()));
      paths.push_back(path.has_filename() ? path : path.parent_path());
    }
  return paths;
}

void read_command(const ConfigNode& root, ExternalVariant& variant) {
  variant.command = read_texts(root, "command");
  if (variant.command.empty()) root.at("command").fail("expected a program and its arguments");
  const auto names = [&](const char* placeholder) {
    return std::ranges::any_of(variant.command, [&](const std::string& argument) {
      return argument.find(placeholder) != std::string::npos;
    });
  };
  for (const char* placeholder : {"{sequence}", "{out}"})
    if (!names(placeholder))
      root.at("command").fail(fmt::format("has no {} in it: the program could not know of it", placeholder));
}

// Files that the command itself names.
void add_named_files(ExternalVariant& variant) {
  for (const std::string& argument : variant.command) {
    const fs::path path = (variant.folder / argument).lexically_normal();
    std::error_code too_long;
    if (!argument.empty() && fs::is_regular_file(path, too_long) &&
        std::ranges::find(variant.inputs, path) == variant.inputs.end())
      variant.inputs.push_back(path);
  }
}

void read_environment(const ConfigNode& root, ExternalVariant& variant) {
  if (const auto map = root.find("environment"))
    for (const auto& [name, value] : map->entries()) {
      if (name.empty() || name.find('=') != std::string::npos) value.fail("is no name of a variable");
      variant.environment.emplace_back(name, value.as<std::string>());
    }
}

void read_limits(const ConfigNode& root, ExternalVariant& variant) {
  const auto limits = root.find("limits");
  if (!limits) return;
  variant.time_limit_s = limits->positive("time_s", variant.time_limit_s);
  variant.memory_limit_mb = limits->positive("memory_mb", variant.memory_limit_mb);
  variant.output_limit_mb = limits->positive("output_mb", variant.output_limit_mb);
  limits->refuse_unknown_keys();
}

void read_sensors(const ConfigNode& root, ExternalVariant& variant) {
  const auto list = root.find("sensors");
  if (!list) return;
  for (const ConfigNode& item : list->items()) {
    variant.sensors.push_back(item.as<std::string>());
    if (std::ranges::find(kSensorNames, variant.sensors.back()) == std::end(kSensorNames))
      item.fail(fmt::format("expected one of {}", fmt::join(kSensorNames, ", ")));
  }
}

// Of a file, or of all files below a folder.
std::string content_hash(const fs::path& path) {
  return fs::is_directory(path) ? Hash().add(list_hashes(path)).hex() : hex(hash_file(path));
}

std::string quoted_list(const std::vector<std::string>& texts) {
  std::vector<std::string> quoted;
  for (const std::string& text : texts) quoted.push_back(yaml_quoted(text));
  return fmt::format("[{}]", fmt::join(quoted, ", "));
}

}  // namespace

std::vector<std::string> sensors_of(const Sequence& sequence) {
  std::vector<std::string> sensors;
  const auto any = [&](auto has) { return std::ranges::any_of(sequence.frames, has); };
  if (!sequence.frames.empty()) sensors.push_back("rgb");
  if (any([](const SequenceFrame& f) { return !f.depth.empty(); })) sensors.push_back("depth");
  if (any([](const SequenceFrame& f) { return !f.masks.empty(); })) sensors.push_back("masks");
  if (sequence.lidar) sensors.push_back("lidar");
  if (sequence.imu) sensors.push_back("imu");
  if (sequence.given_camera) sensors.push_back("given_camera");
  return sensors;
}

std::vector<std::string> missing_sensors(const std::vector<std::string>& wanted,
                                         const std::vector<std::string>& there) {
  std::vector<std::string> missing;
  for (const std::string& sensor : wanted)
    if (std::ranges::find(there, sensor) == there.end()) missing.push_back(sensor);
  return missing;
}

bool is_external(const fs::path& variant_file) {
  const ConfigNode root = ConfigNode::load(variant_file);
  return root.is_map() && root.has("command");
}

ExternalVariant load_external_variant(const fs::path& variant_file) {
  const ConfigNode root = ConfigNode::load(variant_file);
  if (const int schema = root.get<int>("schema", kSchema); schema != kSchema)
    root.at("schema").fail(
        fmt::format("version {} is not supported (this program reads {})", schema, kSchema));
  ExternalVariant variant;
  variant.name = root.name("name", variant_file.stem().string());
  variant.folder = fs::weakly_canonical(fs::absolute(variant_file)).parent_path();
  read_command(root, variant);
  variant.layout = root.choice("layout", kLayouts, variant.layout);
  variant.result = root.choice("result", kResults, variant.result);
  variant.inputs = read_paths(root, "inputs", variant.folder);
  add_named_files(variant);
  variant.mounts = read_paths(root, "mounts", variant.folder);
  for (const fs::path& mount : variant.mounts)
    if (std::ranges::any_of(kNeverMounted, [&](const char* path) { return mount == path; }))
      root.at("mounts").fail(fmt::format("{} would show more than a program's files", mount.string()));
  read_environment(root, variant);
  read_limits(root, variant);
  variant.gpu = root.get<bool>("gpu", variant.gpu);
  read_sensors(root, variant);
  variant.output = root.choice("output", {"causal", "final"}, variant.output);
  root.refuse_unknown_keys();
  return variant;
}

std::string external_yaml(const ExternalVariant& variant) {
  std::vector<std::string> inputs, mounts, environment;
  for (const fs::path& path : variant.inputs)
    inputs.push_back(
        fmt::format("{} {}", path.lexically_relative(variant.folder).string(), content_hash(path)));
  for (const fs::path& path : variant.mounts)
    mounts.push_back(path.lexically_relative(variant.folder).string());
  for (const auto& [name, value] : variant.environment)
    environment.push_back(fmt::format("{}: {}", yaml_quoted(name), yaml_quoted(value)));
  return fmt::format(
      "name: {}\ncommand: {}\nlayout: {}\nresult: {}\ninputs: {}\nmounts: {}\nenvironment: {{{}}}\n"
      "limits: {{time_s: {}, memory_mb: {}, output_mb: {}}}\ngpu: {}\nsensors: {}\noutput: {}\n",
      yaml_quoted(variant.name), quoted_list(variant.command), variant.layout, variant.result,
      quoted_list(inputs), quoted_list(mounts), fmt::join(environment, ", "), variant.time_limit_s,
      variant.memory_limit_mb, variant.output_limit_mb, variant.gpu, quoted_list(variant.sensors),
      variant.output);
}

}  // namespace uniquadric
