#pragma once

#include <cstdint>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "core/sequence/imu.h"
#include "core/sequence/sequence.h"

namespace uniquadric {

/// What writes a measurement of each kind.
struct SensorWriters {
  std::function<void(const ImuSample&)> imu;
  std::function<void(const SequenceFrame&)> frame;
  std::function<void(const SequenceScan&, std::int64_t end_ns)> scan;
};

/// The measurements of a sequence in the order in which drivers send them: each at its stamp, a scan when it
/// is over. For the formats of ROS 1 and ROS 2.
class SensorLog {
 public:
  /// Throws InputError when imu.csv is broken.
  explicit SensorLog(const Sequence& sequence);

  std::int64_t first_ns() const { return first_ns_; }  ///< of all stamps
  /// What is added to all times so that the first is not before 1 s: ROS takes 0 for "no time".
  std::int64_t shift_ns() const;
  /// Shows its progress under that name.
  void replay(const std::string& name, bool quiet, const SensorWriters& writers) const;

 private:
  const Sequence& sequence_;
  std::vector<ImuSample> imu_;
  std::int64_t first_ns_ = 0;
};

/// A frame's depth image [m] as ROS has it (REP 118): NaN where there is none.
cv::Mat ros_depth(const Sequence& sequence, const SequenceFrame& frame);

}  // namespace uniquadric
