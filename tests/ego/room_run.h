#pragma once

#include <algorithm>
#include <cmath>
#include <functional>

#include "estimator/ego/lidar_odometry.h"
#include "tests/ego/lidar_room.h"

namespace uniquadric {

/// Scans of a room, sweep by sweep through the odometry.
struct RoomRun {
  LidarRoom room;
  LidarDataSheet noise;
  LidarOdometryOptions options;
  bool has_imu = true;
  int scans = 40;
  std::function<void(std::vector<ImuSample>&)> change_imu = [](auto&) {};
  Pose camera_from_lidar;
  std::function<bool(int scan)> is_dropped = [](int) { return false; };
  std::function<void(int scan, std::vector<LidarPoint>&)> change = [](int, auto&) {};

  LidarOdometry odometry() const {
    LidarRigView rig;
    rig.noise = noise;
    rig.camera_from_lidar = camera_from_lidar;
    std::vector<ImuSample> samples;
    if (has_imu) {
      rig.imu = ImuCalibration();
      samples = room.imu(scans / room.rate_hz);
      change_imu(samples);
    }
    LidarOdometry odometry(rig, samples, options);
    for (int i = 0; i < scans; ++i) {
      std::vector<LidarPoint> points = room.scan(i);
      change(i, points);
      if (!is_dropped(i)) odometry.add_scan(room.scan_start_ns(i), points);
      odometry.end_sweep(room.scan_start_ns(i + 1));
    }
    odometry.finish();
    return odometry;
  }
};

struct RoomErrors {
  double max_m = 0, max_rad = 0;
  int missing = 0, poses = 0;
};

/// Of the poses at and between the scans' ends, after the first ones have been made to coincide.
inline RoomErrors errors_of(const LidarOdometry& odometry, const RoomRun& run) {
  RoomErrors errors;
  std::optional<Pose> truth_from_estimate;
  for (int i = 0; i <= 3 * run.scans; ++i) {
    const double t = i / (3 * run.room.rate_hz);
    const auto pose = odometry.world_from_camera(run.room.start_ns + std::llround(1e9 * t));
    errors.missing += !pose;
    if (!pose) continue;
    ++errors.poses;
    const Pose truth = run.room.world_from_lidar(t);
    if (!truth_from_estimate) truth_from_estimate = truth * pose->inverse();
    const Pose aligned = *truth_from_estimate * *pose;
    errors.max_m = std::max(errors.max_m, (aligned.translation - truth.translation).norm());
    errors.max_rad = std::max(errors.max_rad, log_so3(aligned.rotation.conjugate() * truth.rotation).norm());
  }
  return errors;
}

}  // namespace uniquadric
