#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/sequence/sequence.h"
#include "estimator/images/repeats.h"

namespace uniquadric {

/// Looks at scans as they are read, for what is no measurement of a working driver.
class ScanWatch {
 public:
  /// Points nearer or farther than these are of no use.
  ScanWatch(double min_range_m, double max_range_m) : min_range_m_(min_range_m), max_range_m_(max_range_m) {}

  /// Whether a point is a return, and of use; none that is no number is.
  bool is_of_use(const LidarPoint& point) const;

  /// The next scan of the sequence.
  void look(const SequenceScan& scan, std::vector<LidarPoint> points);

  /// Of each scan so far, whether all its points of use (two at least) have one time.
  const std::vector<bool>& is_of_an_instant() const { return is_of_an_instant_; }

  /// Scans without a point of use, neighbours with the same points, and points' times that span too little
  /// of a scan (point_times_fault): a sentence each.
  std::vector<std::string> faults(double rate_hz) const;

 private:
  double min_range_m_, max_range_m_;
  std::vector<LidarPoint> last_;
  std::vector<bool> is_of_an_instant_;
  int without_points_ = 0;
  std::int64_t widest_ns_ = 0;  // that the times of a scan's points span
  std::string first_without_points_;
  Repeats repeats_;
};

/// What is missing in lidar.txt: the longest time without a scan, where it is several times that between
/// scans. A sentence; nothing where scans go on.
std::optional<std::string> scan_gap(const Sequence& sequence);

}  // namespace uniquadric
