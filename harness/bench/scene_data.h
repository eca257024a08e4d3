#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "harness/bench/config.h"

namespace uniquadric {

/// What a plan has to know of a scene or recording.
struct SceneData {
  const char* kind;  ///< scene or recording
  std::string hash;
  std::vector<std::string> sensors;
  bool has_routes = false;                    ///< a LiDAR that takes the paper's way
  std::filesystem::path sequence{}, truth{};  ///< of a recording
};

/// Draws the scenes that are of families, and reads all, several at a time. Says how far it is once that
/// takes seconds, unless `quiet`. Throws the InputError of the first one that has a fault.
std::vector<SceneData> look_at_scenes(std::vector<BenchScene>& scenes, bool quiet);

}  // namespace uniquadric
