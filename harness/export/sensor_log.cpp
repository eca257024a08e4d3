#include "harness/export/sensor_log.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>

#include "core/base/progress.h"

namespace uniquadric {
namespace {

constexpr std::int64_t kLeastStamp_ns = 1'000'000'000;  // ours

struct Event {
  std::int64_t time_ns = 0;
  std::function<void()> write;
};

}  // namespace

SensorLog::SensorLog(const Sequence& sequence)
    : sequence_(sequence), first_ns_(std::numeric_limits<std::int64_t>::max()) {
  if (sequence.imu) imu_ = read_imu_csv(sequence.folder / "imu.csv");
  const auto look = [&](const auto& list) {  // every sequence has frames or scans
    if (!list.empty()) first_ns_ = std::min(first_ns_, list.front().stamp_ns);
  };
  look(sequence.frames);
  look(sequence.scans);
  look(imu_);
}

std::int64_t SensorLog::shift_ns() const {
  return std::max<std::int64_t>(0, kLeastStamp_ns - first_ns_);
}

void SensorLog::replay(const std::string& name, bool quiet, const SensorWriters& writers) const {
  std::vector<Event> events;
  for (const ImuSample& sample : imu_) events.push_back({sample.stamp_ns, [&] { writers.imu(sample); }});
  for (const SequenceFrame& frame : sequence_.frames)
    events.push_back({frame.stamp_ns, [&] { writers.frame(frame); }});
  if (sequence_.lidar) {
    const std::int64_t scan_ns = std::llround(1e9 / sequence_.lidar->rate_hz);
    for (const SequenceScan& scan : sequence_.scans) {
      const std::int64_t end_ns = scan.stamp_ns + scan_ns;
      events.push_back({end_ns, [&writers, &scan, end_ns] { writers.scan(scan, end_ns); }});
    }
  }
  std::ranges::stable_sort(events, {}, &Event::time_ns);
  Progress progress(name, std::ssize(events), quiet);
  for (const Event& event : events) {
    event.write();
    progress.advance();
  }
}

cv::Mat ros_depth(const Sequence& sequence, const SequenceFrame& frame) {
  cv::Mat depth_m = read_depth(sequence, frame);
  depth_m.setTo(std::numeric_limits<float>::quiet_NaN(), depth_m == 0);
  return depth_m;
}

}  // namespace uniquadric
