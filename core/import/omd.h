#pragma once

#include <filesystem>

#include "core/import/recording.h"

namespace uniquadric {

struct ImportOmdOptions : ImportOptions {
  /// Raw layout: folder of kalibr*.yaml and vicon*.yaml; empty: the recording's own, else the one it lies in.
  /// Processed layout: settings file (Camera.fx, ...); empty: the only .yaml of the recording.
  std::filesystem::path calibration;
  /// Sizes of the moving bodies, which the data set does not have: an objects.yaml as a truth has it. Empty:
  /// the truth is of the camera alone.
  std::filesystem::path objects;
  double vicon_offset_s = 0;  ///< added to the Vicon's stamps, whose clock is another than the cameras'
  /// Processed layout: whether depth/ holds depths (value / DepthMapFactor [m]) instead of disparities.
  bool metric_depth = false;
};

/// Turns a recording of the Oxford Multimotion Dataset (Judd and Gammell, RA-L 2019) into `out`/sequence and,
/// where poses are known, `out`/truth.
///
/// Raw layout (rgbd/rgbd.csv): the RGB-D camera's images (indices with only one of the two are skipped),
/// depth in mm, intrinsics and distortion of kalibr's cam2, IMU, Vicon. The file's 4x4 matrix is
/// object_from_world: its inverse is taken, and quaternion and translation must say either of the two, in all
/// rows the same, or the file is refused. Rows without a name or with NaN are dropped.
/// world_from_camera = world_from_payload T_apparatus_left inv(T_cam1_cam0) inv(T_cam2_cam1).
///
/// Processed layout (times.txt, image_0/, as VDO-SLAM reads it): depth/ holds disparities d / 1000 px, z = bf
/// / disparity; semantic/ text of ids, which become masks; pose_gt.txt a frame and the 16 numbers of
/// world_from_camera; object_pose.txt a frame, an id, translation and axis times angle of world_from_object.
///
/// Poses are interpolated at the images' stamps and are given ones too. Throws InputError, with file and
/// line, for what is missing or malformed; then nothing is left at `out`.
void import_omd(const std::filesystem::path& recording, const ImportOmdOptions& options,
                const std::filesystem::path& out);

}  // namespace uniquadric
