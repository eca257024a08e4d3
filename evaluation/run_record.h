#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace uniquadric {

/// Milliseconds of each stage in each frame, from an estimate's timing.csv (columns frame, stage, ms; a stage
/// may run several times in a frame, or not at all: 0); empty without the file. `frame` is added as the sum
/// of a frame's stages where no stage has that name. Throws InputError with the line.
std::map<std::string, std::vector<double>> read_timing(const std::filesystem::path& estimate);

/// An estimate's run.yaml as JSON text ("null" without the file): scalars become booleans, numbers or
/// strings.
std::string read_run_config(const std::filesystem::path& estimate);

/// The hash of the scene that a truth (objects.yaml), an estimate (run.yaml) or a sequence (sequence.yaml)
/// says it is of; empty where it does not say: recordings, and what other programs wrote.
std::string scene_of(const std::filesystem::path& folder);

/// A folder and the hash of the scene that it says it is of; empty where it does not say.
struct SceneClaim {
  std::filesystem::path folder;
  std::string scene_hash;
};
/// Stamps of all simulations start at 0: those of another scene would fit. Throws InputError for `other`
/// where both say of what scene they are and say otherwise.
void require_one_scene(const SceneClaim& one, const SceneClaim& other);

/// Whether a run's configuration (read_run_config) says that the estimator was given the camera's poses, so
/// that its world is the truth's: `variant.ego` is `given`, or has `source: given`.
bool camera_was_given(const std::string& run_config_json);

}  // namespace uniquadric
