#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/base/config_overrides.h"
#include "estimator/variant.h"
#include "simulator/families/family.h"

namespace uniquadric {

/// A file that a bench names: its stem is the name of the scene or variant in all results.
struct BenchItem {
  std::string name;
  std::filesystem::path path;
};

/// A scene with what the bench makes of it, one drawn from a family, or a recording.
struct BenchScene : BenchItem {
  bool is_recording = false;                  ///< `path` is a folder that `import` made, else a scene file
  double noise_scale = 1;                     ///< of a scene: of the amplitudes of all its noise
  std::vector<ConfigOverride> set{};          ///< of a scene: in place of the file's values
  std::optional<FamilyRequest> drawn_from{};  ///< of a family: then `path` will stand below the results
  std::string generated{};                    ///< of a family, once it is drawn: the scene
  std::string where{};                        ///< of a family: the place in the bench, as messages begin
  std::vector<std::uint64_t> seeds{};         ///< its own, or the bench's; of a recording [0] by default
  std::string prompt{};                       ///< boxes:FILE or points:FILE; empty: none
  std::vector<std::string> judging{};         ///< options of `evaluate`: --objects, --unlabelled
};

/// A variant's file, with what the bench changes of it.
struct BenchVariant : BenchItem {
  std::vector<ConfigOverride> set{};  ///< in place of the file's values
};

/// scenes x variants x seeds (configs/bench/README.md).
struct BenchConfig {
  std::string name;
  std::vector<BenchScene> scenes;
  std::vector<BenchVariant> variants;
  std::vector<std::uint64_t> seeds;
  std::optional<std::int64_t> frames;  ///< instead of each scene's own number
  bool keep_sequences = false;         ///< ours: 250 MB a sequence would fill a disk in a sweep
  double stage_limit_s = 3600;         ///< ours: a stage that hangs is killed after this time
  int overlays = 8;                    ///< frames with overlays a cell
};

/// Reads a bench file; paths in it are relative to it. Throws InputError with file and line, also for a scene
/// or variant that is missing.
BenchConfig load_bench_config(const std::filesystem::path& path);

/// The resolved configuration as a bench file that stands in `folder`: what it names is named from there.
std::string bench_yaml(const BenchConfig& config, const std::filesystem::path& folder);

}  // namespace uniquadric
