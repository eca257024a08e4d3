#pragma once

#include <filesystem>

#include "core/import/recording.h"

namespace uniquadric {

struct ImportEurocOptions : ImportOptions {
  /// Depth of cam0 by matching with cam1, without which no estimate can be made of it: the sequence's images
  /// are then the rectified ones. Else cam0's images as they are.
  bool stereo_depth = true;
};

/// Turns a recording in the layout of the EuRoC MAV datasets (Burri et al., IJRR 2016; a folder with `mav0/`,
/// or that itself) into `out`/sequence and, where there is state_groundtruth_estimate0, `out`/truth (the
/// camera's poses; no objects). Taken are cam0 (images, stamps in ns, pinhole intrinsics with
/// radial-tangential distortion, T_BS) and, where it is there, imu0 (samples, T_BS, noise densities). Grey
/// images become colour ones of three equal channels. Poses of the body (p, q as w x y z) times T_BS are the
/// camera's, interpolated at its stamps; they are given ones too. Throws InputError, with
/// file and line or field, for what is missing or malformed; then nothing is left at `out`.
void import_euroc(const std::filesystem::path& recording, const ImportEurocOptions& options,
                  const std::filesystem::path& out);

}  // namespace uniquadric
