#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/sequence/sequence.h"
#include "estimator/ego/lidar_odometry.h"
#include "estimator/lidar/scan_watch.h"

namespace uniquadric {

/// Where one sweep of points ends and the next begins.
enum class SweepCut {
  frames,  ///< paper: soft synchronisation, at the camera's frames, by the points' own stamps
  scans,   ///< at the scans' ends; the camera's poses lie between
};

struct LidarEgoOptions {
  SweepCut cut = SweepCut::frames;
  std::int64_t imu_time_offset_ns = 0;  ///< the IMU's clock less the sequence's
  LidarOdometryOptions odometry;
};

/// LiDAR odometry of a sequence: reads its scans and IMU as frames go by. Scans are on the sequence's clock
/// (on_camera_clock).
class LidarEgo {
 public:
  /// The sequence has to outlive this. Throws InputError as require_scans() does, and when the
  /// IMU that the options ask for has no reading in the time of the scans.
  LidarEgo(const Sequence& sequence, const LidarEgoOptions& options);

  /// Frames in their order; `masks` CV_16UC1 or empty: labels other than 0 are left out. Throws InputError
  /// for scans that cannot be read.
  void track(const SequenceFrame& frame, const cv::Mat& masks);
  /// Takes what scans are left.
  void finish();
  /// Of the frames, or of the scans' ends where the sequence has no frames. After finish().
  std::vector<std::int64_t> stamps_ns() const;
  /// world_from_camera at these stamps, but those where the sensor was lost.
  Trajectory trajectory() const;
  /// What is wrong with the IMU's readings (imu_faults) and the scans (ScanWatch), whether points have no
  /// times although the sensor moves, whether the IMU agrees with the scans by biases alone that none has,
  /// whether scans no longer lie on the map, and whether the sensor is too restless to be followed without an
  /// IMU: a sentence each. After finish().
  std::vector<std::string> scan_faults() const;

  const LidarOdometry& odometry() const { return odometry_; }

 private:
  void take_scans(std::int64_t until_ns);
  void note_end(const SequenceScan& scan, const std::vector<LidarPoint>& points);
  bool is_known_to_rest(std::size_t scan) const;
  std::optional<std::string> bias_fault() const;
  std::optional<std::string> map_fault() const;
  std::optional<std::string> restless_fault() const;

  const Sequence& sequence_;
  LidarEgoOptions options_;
  std::vector<std::string> imu_faults_;  // before the odometry, for whose readings they are found
  LidarOdometry odometry_;
  ScanWatch watch_;
  std::size_t next_scan_ = 0, next_end_ = 0;
  std::vector<std::int64_t> ends_ns_;  // of the scans that were read
};

}  // namespace uniquadric
