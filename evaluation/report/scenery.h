#pragma once

#include <filesystem>

namespace uniquadric {

struct SceneryOptions {
  int frames = 75;               ///< ours: of 150 to 300 every second to fourth, smooth to look at
  int width_px = 320;            ///< ours: 10 kB a frame
  std::size_t points = 6000;     ///< ours: of the cloud, 100 kB
  std::size_t triangles = 1200;  ///< ours: of a mesh, 20 kB; larger ones are simplified
};

/// What the report shows of a sequence whatever was estimated, kept when the sequence itself is deleted:
/// `out`/frames/NNNNNN.jpg, evenly spaced colour images, small and without lens distortion, and
/// `out`/scenery.json:
/// {"camera": {"width", "height", "fx", "fy", "cx", "cy"} of the whole image, "frames": [{"frame",
/// "stamp_ns"}], "meshes": [{"id", "positions_mm": [x, y, z, ...], "triangles": [i, j, k, ...]}] of true
/// objects in their frames, "cloud": {"positions_mm", "colors": [0xrrggbb]} of the depth images, else of the
/// LiDAR's scans, in the truth's world}. Meshes and cloud need a truth; `truth` may be empty. Throws
/// InputError for folders that cannot be read, and for an `out` that exists, unless `force` replaces it.
void write_scenery(const std::filesystem::path& sequence, const std::filesystem::path& truth,
                   const std::filesystem::path& out, const SceneryOptions& options, bool force);

}  // namespace uniquadric
