#pragma once

#include <filesystem>

#include "simulator/scene/scene.h"

namespace uniquadric {

struct PreviewOptions {
  int frames = 3;      ///< ours: enough to see what moves; evenly spaced, without the ends
  int width_px = 720;  ///< of the whole picture
};

/// Draws a few frames of a scene side by side, without noise, and writes them as a JPEG. Throws InputError
/// when the scene cannot be drawn or has fewer frames.
void write_preview(const Scene& scene, const PreviewOptions& options, const std::filesystem::path& jpeg);

}  // namespace uniquadric
