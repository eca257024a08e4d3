#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include <Eigen/Core>

#include "core/sequence/sequence.h"
#include "estimator/lidar/scan_watch.h"

namespace uniquadric {

/// Throws InputError naming lidar.txt when the sequence has no scan, or has frames and no scan meets their
/// time.
void require_scans(const Sequence& sequence);

/// The sequence with its scans on the camera's clock. `lidar_less_camera_ns` is what the LiDAR's clock shows
/// more than the camera's at one instant; it is taken off the scans' stamps.
Sequence on_camera_clock(Sequence sequence, std::int64_t lidar_less_camera_ns);

inline constexpr double kMostRange_m = 1000;  // ours: no LiDAR of a vehicle sees as far

/// The points of a sequence's scans in the order of their own times, cut anew wherever the reader wants (soft
/// synchronisation, SPEC 4): scans are files of a driver, not of the camera. Empty returns (0, 0, 0), points
/// that are not finite and those farther off than kMostRange_m are passed over.
class LidarStream {
 public:
  explicit LidarStream(const Sequence& sequence) : sequence_(sequence), watch_(0, kMostRange_m) {}

  /// All points not yet taken with stamps up to `until_ns`, in order of time. Throws InputError naming a file
  /// that cannot be read.
  std::vector<TimedPoint> take(std::int64_t until_ns);

  /// Of the scans that were read.
  const ScanWatch& watch() const { return watch_; }

 private:
  const Sequence& sequence_;
  ScanWatch watch_;
  std::size_t next_scan_ = 0;
  std::deque<TimedPoint> waiting_;
};

}  // namespace uniquadric
