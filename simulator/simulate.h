#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "simulator/render/gl_context.h"
#include "simulator/scene/scene.h"

namespace uniquadric {

struct SimulateOptions {
  std::uint64_t seed = 0;
  std::optional<std::int64_t> frames;   ///< instead of the scene's own number
  int threads = 0;                      ///< 0: as many as the machine has
  GlLibrary gl = GlLibrary::automatic;  ///< both draw the same bytes on llvmpipe
  std::filesystem::path timing;         ///< file for what the stages took (StageTimes::csv); empty: none
  bool quiet = false;
  bool force = false;  ///< replace an existing output folder
};

/// Renders a scene to `out/sequence/` (observations) and `out/truth/` (exact poses, masks, sizes). The same
/// scene and seed give the same bytes for any number of threads; an interrupted run resumes from the frames
/// it had finished.
void simulate(const Scene& scene, const SimulateOptions& options, const std::filesystem::path& out);

}  // namespace uniquadric
