#pragma once

#include <filesystem>
#include <string>

#include "core/import/recording.h"

namespace uniquadric {

struct ImportKittiOptions : ImportOptions {
  /// Which recording of the folder (`0000`); empty: the only one.
  std::string drive;
};

/// Turns a recording in the layout of KITTI's tracking benchmark into `out`/sequence and, where there are
/// camera poses, `out`/truth: they and what labels they place in the world. Taken of it is what is there,
/// image_02 or velodyne at least: colour (checked and copied byte for byte), scans (.bin or .pcd), calib
/// (required with images, labels or oxts), poses (else oxts: both world_from_camera, given and true),
/// label_02 (boxes that stand upright for the camera, each track with the median of its sizes), times (else
/// 10 frames a second). A scan ends at its frame's stamp; points without times are all of then. Files of
/// consecutive frames with the same bytes are one scan, of the frame in their middle. A track 0 gets a number
/// of its own, for ids are positive. Says on stderr where labels are left out for want of poses. Throws
/// InputError, with file and line or field, for what is missing or malformed; then nothing is left at `out`.
void import_kitti_tracking(const std::filesystem::path& recording, const ImportKittiOptions& options,
                           const std::filesystem::path& out);

}  // namespace uniquadric
