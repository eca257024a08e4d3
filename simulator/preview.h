#pragma once

#include <filesystem>

#include "core/base/files.h"
#include "simulator/scene/scene.h"

namespace uniquadric {

struct PreviewOptions {
  int frames = 3;      ///< ours: enough to see what moves; evenly spaced, without the ends
  int width_px = 720;  ///< of the whole picture
};

/// What a picture of that name is: a PNG (.png), else a JPEG.
FileKind picture_kind(const std::filesystem::path& picture);

/// Throws InputError for a name that ends in neither .png nor .jpg nor .jpeg.
void require_picture_ending(const std::filesystem::path& picture);

/// Draws a few frames of a scene side by side, without noise, and writes them as the picture that its ending
/// says. Throws InputError for another ending, and when the scene cannot be drawn or has fewer frames.
void write_preview(const Scene& scene, const PreviewOptions& options, const std::filesystem::path& file);

}  // namespace uniquadric
