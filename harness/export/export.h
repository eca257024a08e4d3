#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace uniquadric {

struct ExportOptions {
  /// Truth folder of the sequence. Empty: the folder `truth` beside it when there is one. Without truth, what
  /// needs it (labels, objects' poses, exact masks) is left out.
  std::filesystem::path truth;
  std::filesystem::path
      estimate;  ///< `mcap`: estimate folder that is exported beside the truth; may be empty
  /// `ply`: every which frame and which row and column of its depth go into the cloud.
  int frame_stride = 5;  // ours: neighbours at 30 Hz see the same surfaces
  int pixel_stride = 2;  // ours: a quarter of the pixels; 300 frames of 640x480 are then 4.6 M points
  bool quiet = false;
  bool force = false;  ///< replace an existing output folder
};

/// Names that export_sequence() takes: tum, kitti-tracking, bop, euroc, rosbag, ply, vdo, mcap.
std::vector<std::string> export_formats();

/// Writes a sequence to the folder `out` in the layout of another tool; what each format carries, its frames
/// and units, and what is lost on the way stand in docs/export.md. Throws InputError for an unknown format, a
/// sequence or truth that is broken, and a format that cannot hold the sequence; then nothing is left at
/// `out`.
void export_sequence(const std::string& format, const std::filesystem::path& sequence,
                     const std::filesystem::path& out, const ExportOptions& options);

}  // namespace uniquadric
