#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/geometry/camera.h"
#include "core/geometry/pose.h"
#include "core/sequence/lidar.h"

namespace uniquadric {

struct PcdFile;

// Files of KITTI's tracking benchmark (Geiger et al., CVPR 2012; devkit_tracking/readme.txt). Readers throw
// InputError with file and line. `rectified` is the frame of camera 0 after rectification, in which labels
// and poses stand; the images are camera 2's.

struct KittiCalibration {
  Camera camera;               ///< of P2; width and height are not in the file
  Pose camera_from_rectified;  ///< what P2 says of camera 2's place
  Pose camera_from_velodyne, velodyne_from_imu;
};

/// calib/DRIVE.txt: rows `KEY numbers`, with or without a colon: P2, R_rect (or R0_rect), Tr_velo_cam (or
/// Tr_velo_to_cam) and, where it is wanted, Tr_imu_velo (or Tr_imu_to_velo).
KittiCalibration read_kitti_calibration(const std::filesystem::path& path, bool needs_imu);

/// The pose of KITTI's velodyne axes (x forward, y left, z up) at the camera's centre.
Pose camera_from_velodyne_axes();

/// A line of label_02: a box that stands upright in the rectified frame.
struct KittiLabel {
  std::int64_t frame = 0;
  int id = 0;
  std::string type;
  Pose rectified_from_object;  ///< centre of the box; x along its length, z up
  Eigen::Vector3d semi_axes_m = Eigen::Vector3d::Ones();
};

/// label_02/DRIVE.txt without its DontCare regions. A frame beyond `frames`, a size that is not positive, a
/// turn of more than 2 pi (degrees) and an object that stands twice in a frame are errors.
std::vector<KittiLabel> read_kitti_labels(const std::filesystem::path& path, std::int64_t frames);

/// The first number behind all labels' ids. Ids of objects are positive: a track 0 gets this one.
int first_free_id(const std::vector<KittiLabel>& labels);
int object_id(const KittiLabel& label, int free_id);

/// poses/DRIVE.txt, 12 numbers a frame (first_camera_from_camera), as world_from_rectified: the world is the
/// first camera's, turned so that its z is that camera's up.
std::vector<Pose> read_kitti_poses(const std::filesystem::path& path);

/// oxts/DRIVE.txt, 30 numbers a frame, as world_from_imu: east, north, up from the first place (Mercator, as
/// the raw data's devkit has it).
std::vector<Pose> read_kitti_oxts(const std::filesystem::path& path);

/// A scan's points, and the fields of its file that none of them has: name and type each.
struct KittiScan {
  std::vector<LidarPoint> points;
  std::vector<std::string> left_out;
};

/// velodyne/DRIVE/FRAME.bin (float32 x y z reflectance) or .pcd: x y z and, where it has them, intensity (F4
/// or U1), ring (U2 or U1), tag (U1) and a time, the first of t, offset_time (U4: ns; F4, F8: s since the
/// scan's start), time (F4, F8: so, too) and timestamp (F4, F8: s, counted from the scan's first point).
/// Points without times have `end_ns`; a return at no time of a scan is an error.
KittiScan read_kitti_scan(const std::filesystem::path& path, std::uint32_t end_ns);
/// The same of a .pcd's contents; `path` names them in messages.
KittiScan scan_of_points(const std::filesystem::path& path, const PcdFile& file, std::uint32_t end_ns);

}  // namespace uniquadric
