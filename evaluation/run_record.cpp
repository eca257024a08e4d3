#include "evaluation/run_record.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/base/config.h"
#include "core/base/error.h"
#include "core/base/text.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

constexpr double kMostMs = 1e12;  // thirty years

json scalar_json(const std::string& text) {
  if (text == "true" || text == "false") return text == "true";
  if (text == "null" || text == "~") return nullptr;
  if (const auto integer = parse_integer(text)) return *integer;
  if (const auto number = parse_double(text)) return *number;
  return text;
}

json to_json(const ConfigNode& node) {
  if (node.is_map()) {
    json object = json::object();
    for (const auto& [key, value] : node.entries()) object[key] = to_json(value);
    return object;
  }
  if (node.is_sequence()) {
    json list = json::array();
    for (const ConfigNode& item : node.items()) list.push_back(to_json(item));
    return list;
  }
  return node.is_scalar() ? scalar_json(node.as<std::string>()) : json();
}

}  // namespace

std::map<std::string, std::vector<double>> read_timing(const fs::path& estimate) {
  const fs::path file = estimate / "timing.csv";
  if (!fs::exists(file)) return {};
  std::map<std::string, std::map<long long, double>> sums;
  std::map<long long, double> frames;
  bool header = true;
  for_each_line(
      file,
      [&](int line, const std::vector<std::string_view>& fields) {
        if (std::exchange(header, false)) {
          if (fields != split("frame,stage,ms", ','))
            throw InputError(file, line, "expected the header frame,stage,ms");
          return;
        }
        if (fields.size() != 3)
          throw InputError(file, line, fmt::format("expected 3 columns, found {}", fields.size()));
        const auto frame = parse_integer(fields[0]);
        const auto ms = parse_double(fields[2]);
        if (!is_plain_name(fields[1]))
          throw InputError(file, line, fmt::format("column stage: '{}' is no plain name", fields[1]));
        if (!frame) throw InputError(file, line, fmt::format("column frame: '{}' is no integer", fields[0]));
        if (!ms || *ms < 0 || *ms > kMostMs)
          throw InputError(file, line, fmt::format("column ms: '{}' is no time", fields[2]));
        sums[std::string(fields[1])][*frame] += *ms;
        frames[*frame] += *ms;
      },
      ',');
  if (!frames.empty()) sums.try_emplace("frame", frames);
  std::map<std::string, std::vector<double>> stages;
  for (auto& [stage, of_frames] : sums)
    for (const auto& [frame, ms] : frames) stages[stage].push_back(of_frames[frame]);
  return stages;
}

std::string read_run_config(const fs::path& estimate) {
  const fs::path file = estimate / "run.yaml";
  return (fs::exists(file) ? to_json(ConfigNode::load(file)) : json()).dump();
}

std::string scene_of(const fs::path& folder) {
  for (const char* name : {"run.yaml", "objects.yaml", "sequence.yaml"}) {
    const fs::path file = folder / name;
    if (!fs::exists(file)) continue;
    const ConfigNode root = ConfigNode::load(file);
    return root.is_map() ? root.get<std::string>("scene_hash", "") : "";
  }
  return {};
}

void require_one_scene(const SceneClaim& one, const SceneClaim& other) {
  if (one.scene_hash.empty() || other.scene_hash.empty() || one.scene_hash == other.scene_hash) return;
  throw InputError(other.folder, fmt::format("is of another scene: its scene_hash is {}, that of {} is {}",
                                             other.scene_hash, one.folder.string(), one.scene_hash));
}

bool camera_was_given(const std::string& run_config_json) {
  const json config = json::parse(run_config_json);
  if (!config.is_object()) return false;
  const json variant = config.value("variant", json());
  const json ego = variant.is_object() ? variant.value("ego", json()) : json();
  return ego == "given" || (ego.is_object() && ego.value("source", json()) == "given");
}

}  // namespace uniquadric
