#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "core/sequence/lidar.h"
#include "core/sequence/trajectory.h"
#include "estimator/ego/lidar_track.h"

namespace uniquadric {

/// LiDAR odometry after FAST-LIO2 (arXiv 2107.06829): sweeps of points, each by its own stamp, are put to a
/// map by an error-state iterated Kalman filter on point-to-plane distances, by an IMU or at constant
/// velocity. The world has its origin at the camera's first place and z up: by gravity with an IMU, else by
/// the ground that the first scan sees, else by the LiDAR's own up.
class LidarOdometry {
 public:
  LidarOdometry(const LidarRigView& rig, std::vector<ImuSample> imu, const LidarOdometryOptions& options);
  LidarOdometry(LidarOdometry&& other) noexcept;
  ~LidarOdometry();

  /// Points of a scan, in any order. Bad ones are passed over (clean_points). Throws std::invalid_argument
  /// for times that no scan has.
  void add_scan(std::int64_t start_ns, const std::vector<LidarPoint>& points);
  /// Where bodies are that may move (CV_16UC1, 0 background), stamps in order: points that fall on them near
  /// that time do not count.
  void add_masks(std::int64_t stamp_ns, const cv::Mat& masks);
  /// Ends a sweep: all points up to here that no other had. Stamps in order. No points: the motion goes on.
  void end_sweep(std::int64_t end_ns);
  /// Ends the beginning, where fewer sweeps came than first_sweeps.
  void finish();

  /// Of a stamp within the sweeps, or a sweep's length beside them; nothing elsewhere and where lost.
  std::optional<Pose> world_from_camera(std::int64_t stamp_ns) const;
  const std::vector<SweepReport>& reports() const;
  /// After the last sweep; with an IMU, its biases.
  const LidarState& state() const;
  std::size_t map_blocks() const;
  /// What is known of the surroundings at the end, in the world of the poses: means of the map's finest
  /// cells.
  std::vector<Eigen::Vector3d> map_points() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace uniquadric
