#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/sequence/imu.h"
#include "core/sequence/lidar.h"
#include "estimator/ego/lidar_filter.h"

namespace uniquadric {

/// All numbers are ours.
struct SweepOptions {
  double min_range_m = 0.5;  // what is nearer is the vehicle
  double max_range_m = 120;
  double voxel_m = 0.25;                   // one point a voxel is put to the map
  static constexpr double max_scan_s = 1;  // a point later in its scan than this has no time but a mistake
};

/// The points of a scan that are points, in the order of their times: empty returns (0, 0, 0), numbers that
/// are not finite and ranges out of bounds are left out. Throws std::invalid_argument for a time beyond
/// max_scan_s.
std::vector<TimedPoint> clean_points(std::int64_t start_ns, const std::vector<LidarPoint>& points,
                                     const SweepOptions& options);

/// Of a beam over the sensor's own level.
inline double elevation_rad(const Eigen::Vector3f& lidar) {
  return std::atan2(lidar.z(), lidar.head<2>().norm());
}

/// The readings of an IMU between two times: pieces in which they hardly change.
struct ReadingPiece {
  std::int64_t end_ns = 0;
  InertialReading reading;
};
/// From from_ns to to_ns; readings at the middle of each piece, linear between samples, held at the ends.
/// Without samples one piece of zeros.
std::vector<ReadingPiece> readings_between(const std::vector<ImuSample>& samples, std::int64_t from_ns,
                                           std::int64_t to_ns);

/// The motion through a sweep as it was predicted, to place its points by (motion compensation, FAST-LIO2
/// Sec. IV-A; Eq. 2-3 of the paper).
class SweepPath {
 public:
  /// From the state at the sweep's start.
  SweepPath(const LidarState& start, const std::vector<ReadingPiece>& pieces);
  const LidarState& end() const { return end_; }
  /// Stamps outside the path are placed as its nearest end.
  SweepPoint place(std::int64_t stamp_ns, const Eigen::Vector3d& body) const;

 private:
  struct Piece {
    LidarState start;
    InertialReading reading;
  };
  std::vector<Piece> pieces_;
  LidarState end_;
};

/// For each point the number of its voxel, counted from 0 in the order they are first met, and for each voxel
/// the point that stands for it. Points are taken in an order that favours no part of the sweep.
struct VoxelChoice {
  std::vector<int> voxel_of;
  std::vector<int> point_of;
};
VoxelChoice choose_points(const std::vector<TimedPoint>& points, double voxel_m);

}  // namespace uniquadric
