#include "estimator/lidar/lidar_stream.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.h"

namespace uniquadric {

void require_scans(const Sequence& sequence) {
  const auto& scans = sequence.scans;
  const auto& frames = sequence.frames;
  const std::filesystem::path file = sequence.folder / "lidar.txt";
  if (scans.empty()) throw InputError(file, "names no scan, which the variant needs");
  if (frames.empty()) return;
  const std::int64_t first_ns = scans.front().stamp_ns;
  const std::int64_t end_ns = scans.back().stamp_ns + std::llround(1e9 / sequence.lidar->rate_hz);
  if (first_ns > frames.back().stamp_ns || end_ns < frames.front().stamp_ns)
    throw InputError(
        file, fmt::format("no scan meets a frame: the scans span {}..{} s, the frames {}..{} s",
                          format_stamp(first_ns), format_stamp(end_ns), format_stamp(frames.front().stamp_ns),
                          format_stamp(frames.back().stamp_ns)));
}

Sequence on_camera_clock(Sequence sequence, std::int64_t lidar_less_camera_ns) {
  for (SequenceScan& scan : sequence.scans) scan.stamp_ns -= lidar_less_camera_ns;
  return sequence;
}

std::vector<TimedPoint> LidarStream::take(std::int64_t until_ns) {
  while (next_scan_ < sequence_.scans.size() && sequence_.scans[next_scan_].stamp_ns <= until_ns) {
    const SequenceScan& scan = sequence_.scans[next_scan_++];
    std::vector<LidarPoint> points = read_lidar_points(sequence_.folder / scan.file);
    for (const LidarPoint& p : points)
      if (watch_.is_of_use(p)) waiting_.push_back({scan.stamp_ns + p.offset_ns, {p.x, p.y, p.z}});
    watch_.look(scan, std::move(points));
    std::stable_sort(waiting_.begin(), waiting_.end(),
                     [](const TimedPoint& a, const TimedPoint& b) { return a.stamp_ns < b.stamp_ns; });
  }
  const auto end = std::partition_point(waiting_.begin(), waiting_.end(),
                                        [&](const TimedPoint& p) { return p.stamp_ns <= until_ns; });
  std::vector<TimedPoint> taken(waiting_.begin(), end);
  waiting_.erase(waiting_.begin(), end);
  return taken;
}

}  // namespace uniquadric
