#pragma once

#include <filesystem>

namespace uniquadric {

/// How large a fabricated results folder is.
struct FabricatedOptions {
  int seeds = 2, frames = 300, overlays = 3;
  int image_width_px = 64;
  bool with_failure = true;  ///< the last cell failed
};

/// Writes a plausible results folder as `bench` lays it out: 2 scenes x 2 objects x 2 variants x seeds. Its
/// medians are known: `ape_translation_rmse_m` of seed s is 0.01 * s for variant rotbbox and 0.5 * s for
/// single_frame_obb. The 3D view's poses: object `id` at frame k lies at (0.01 k - 1, 0.8 id, 0.5) m, its
/// estimate 0.01 s or 0.5 s m further along y, lost in frames 120 to 129 for id 1; track 7 is no object's.
void fabricate_results(const std::filesystem::path& folder, const FabricatedOptions& options = {});

}  // namespace uniquadric
