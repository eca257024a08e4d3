#include "harness/bench/keys.h"

#include "core/base/files.h"
#include "core/base/folder_hashes.h"
#include "core/base/hash.h"
#include "core/base/source_hashes.h"
#include "core/base/version.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

fs::path key_file(const fs::path& folder) {
  return folder.string() + ".key";
}

Hash stage(const char* name, const char* sources) {
  Hash hash;
  hash.add(name).add(kProgram).add(kcore_sources).add(sources);
  return hash;
}

}  // namespace

std::string simulation_key(const std::string& scene_hash, std::uint64_t seed,
                           std::optional<std::int64_t> frames) {
  return stage("simulate", ksimulator_sources)
      .add(scene_hash)
      .add(seed)
      .add(static_cast<std::uint64_t>(frames.value_or(0)))
      .hex();
}

std::string recording_key(const fs::path& sequence, const fs::path& truth) {
  Hash hash;
  hash.add("recording");
  for (const fs::path& folder : {sequence, truth})
    if (!folder.empty()) hash.add(list_hashes(folder));
  return hash.hex();
}

std::string perception_key(const std::string& simulation_key, const std::string& perception_yaml,
                           std::uint64_t seed) {
  return stage("perceive", kestimator_sources).add(simulation_key).add(perception_yaml).add(seed).hex();
}

std::string estimate_key(const std::string& simulation_key, const std::string& variant_yaml,
                         std::uint64_t seed) {
  return stage("estimate", kestimator_sources).add(simulation_key).add(variant_yaml).add(seed).hex();
}

std::string evaluation_key(const std::string& estimate_key, const std::vector<std::string>& options) {
  Hash hash = stage("evaluate", kevaluation_sources);
  hash.add(estimate_key);
  for (const std::string& option : options) hash.add(option);
  return hash.hex();
}

std::string scenery_key(const std::string& simulation_key) {
  return stage("scenery", kevaluation_sources).add(simulation_key).hex();
}

std::string overlay_key(const std::string& estimate_key, int count, const std::string& color) {
  return stage("overlay", kevaluation_sources)
      .add(estimate_key)
      .add(static_cast<std::uint64_t>(count))
      .add(color)
      .hex();
}

bool is_current(const fs::path& folder, const std::string& key) {
  if (!fs::is_directory(folder) || !fs::is_regular_file(key_file(folder))) return false;
  const std::string text = read_text(key_file(folder));
  return text.starts_with(key + '\n') && holds_all_of(std::string_view(text).substr(key.size() + 1), folder);
}

void forget_key(const fs::path& folder) {
  fs::remove(key_file(folder));
}

void record_key(const fs::path& folder, const std::string& key) {
  write_text(key_file(folder), key + '\n' + list_hashes(folder));
}

}  // namespace uniquadric
