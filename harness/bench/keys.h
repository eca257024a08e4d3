#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace uniquadric {

/// Keys of the pipeline's stages: each a hash of everything its result depends on, the sources of the code
/// included.
std::string simulation_key(const std::string& scene_hash, std::uint64_t seed,
                           std::optional<std::int64_t> frames);
/// Of a recording: of all its files. An empty `truth`: none.
std::string recording_key(const std::filesystem::path& sequence, const std::filesystem::path& truth);
std::string perception_key(const std::string& simulation_key, const std::string& perception_yaml,
                           std::uint64_t seed);
std::string estimate_key(const std::string& simulation_key, const std::string& variant_yaml,
                         std::uint64_t seed);
std::string evaluation_key(const std::string& estimate_key, const std::vector<std::string>& options);
std::string scenery_key(const std::string& simulation_key);
std::string overlay_key(const std::string& estimate_key, int count, const std::string& color);

/// Whether `folder` holds the result of the stage with this key, whole: FOLDER.key beside it has the key and
/// the hashes of the stage's files, and none of these is missing or changed. Other files do not count.
bool is_current(const std::filesystem::path& folder, const std::string& key);
/// To be called before a stage runs again: a crash leaves no folder with another run's key.
void forget_key(const std::filesystem::path& folder);
void record_key(const std::filesystem::path& folder, const std::string& key);

}  // namespace uniquadric
