#pragma once

#include <filesystem>

#include "core/sequence/sequence.h"
#include "core/sequence/tracks.h"

namespace uniquadric {

/// A result in the layout of KITTI's tracking benchmark: lines of labels with or without a score
/// (read_kitti_labels), whose frames count the sequence's images, or its scans where it has no images.
/// `source` is the file, or a folder with one NNNN.txt in it, in data/ or in label_02/. Beside it may stand
/// poses/NNNN.txt or camera.tum (of the camera; else camera_of_result) and calib/NNNN.txt, which places the
/// rectified frame; without it that is the camera's. Boxes keep their sizes of each frame; a track 0 gets a
/// number of its own. Throws InputError with file and line.
Tracks read_kitti_result(const std::filesystem::path& source, const Sequence& sequence);

}  // namespace uniquadric
