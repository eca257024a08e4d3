#pragma once

#include <filesystem>

#include "core/import/recording.h"

namespace uniquadric {

struct ImportTumOptions : ImportOptions {
  /// Calibration: a YAML map with width, height, fx, fy, cx, cy [px], depth_units_per_metre (value of a depth
  /// pixel at 1 m) and, where there is any, distortion [k1 k2 p1 p2 k3]. Empty: `camera.yaml` in the
  /// recording.
  std::filesystem::path camera;
  double max_pose_gap_s = kMaxPoseGap_s;
};

/// Turns a recording in the layout of the TUM RGB-D benchmark (rgb.txt, depth.txt, and, where it exists,
/// groundtruth.txt = world_from_camera) into a sequence folder. The images are checked (decodable, the
/// camera's size) and copied byte for byte; depth is associated as the benchmark does it, nearest within 0.02
/// s. The camera's poses at the colour images' stamps go to camera_given.tum: exact where a pose has the same
/// stamp, interpolated within the span of the ground truth, absent elsewhere. Throws InputError, with file
/// and line where there is one, for missing files, malformed lines, unordered stamps and bad images; then
/// nothing is left at `out`.
void import_tum(const std::filesystem::path& recording, const ImportTumOptions& options,
                const std::filesystem::path& out);

}  // namespace uniquadric
