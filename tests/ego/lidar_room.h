#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/geometry/pose.h"
#include "core/sequence/imu.h"
#include "core/sequence/lidar.h"

namespace uniquadric {

/// A LiDAR that sways through a room of six walls with six cupboards in it, every point cast where the sensor
/// is at its own time, by closed form. The world has its origin at the room's middle.
struct LidarRoom {
  enum class Pattern { spinning, rings, forward };  // 32 lines 4 deg apart, 16 lines 2 deg apart, a rosette
  Pattern pattern = Pattern::spinning;
  Eigen::Vector3d half_size_m{7, 5, 2.5};
  double range_sigma_m = 0;
  int points = 12'000;  // a scan
  double rate_hz = 10;
  double vigour = 1;                                            // of the motion: 1 m/s and 0.5 rad/s
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();       // besides
  Eigen::Vector3d acceleration_mps2 = Eigen::Vector3d::Zero();  // likewise, from the first scan on
  double tilt_rad = 0;                                          // of the sensor, nose down
  bool is_bare = false;                                         // no cupboards
  bool has_piers = false;                                       // along both long walls, in their place
  double max_range_m = 1e9;                                     // what is farther gives no return
  std::int64_t start_ns = 0;
  Eigen::Vector3d gyroscope_bias_radps = Eigen::Vector3d::Zero(),
                  accelerometer_bias_mps2 = Eigen::Vector3d::Zero();

  /// A box that goes through the room at a constant velocity, none where its half size is 0.
  Eigen::Vector3d mover_half_m = Eigen::Vector3d::Zero(), mover_start_m = Eigen::Vector3d::Zero(),
                  mover_velocity_mps = Eigen::Vector3d::Zero();

  Pose world_from_lidar(double time_s) const;
  /// Centre of the box that moves.
  Eigen::Vector3d mover_m(double time_s) const { return mover_start_m + time_s * mover_velocity_mps; }
  std::int64_t scan_start_ns(int scan) const;
  std::vector<LidarPoint> scan(int scan) const;
  /// At the LiDAR's own place and axes.
  std::vector<ImuSample> imu(double duration_s, double rate_hz = 200) const;
  /// Distance of a point from the nearest surface.
  double off_surfaces_m(const Eigen::Vector3d& p) const;
};

}  // namespace uniquadric
