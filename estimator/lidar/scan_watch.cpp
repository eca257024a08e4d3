#include "estimator/lidar/scan_watch.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <limits>

#include "core/base/quantile.h"
#include "core/base/seconds.h"
#include "core/sequence/stamps.h"

namespace uniquadric {
namespace {

constexpr double kGap = 3.5;  // times the usual: one or two scans may be lost on the way

// Bit by bit, for returns that are no numbers are the same, too. Times are the driver's.
bool is_same_place(const LidarPoint& a, const LidarPoint& b) {
  const auto bits = [](float value) { return std::bit_cast<std::uint32_t>(value); };
  return bits(a.x) == bits(b.x) && bits(a.y) == bits(b.y) && bits(a.z) == bits(b.z);
}

}  // namespace

bool ScanWatch::is_of_use(const LidarPoint& point) const {
  const double square_m2 = Eigen::Vector3d(point.x, point.y, point.z).squaredNorm();
  return square_m2 > 0 && square_m2 >= min_range_m_ * min_range_m_ &&
         square_m2 <= max_range_m_ * max_range_m_;
}

void ScanWatch::look(const SequenceScan& scan, std::vector<LidarPoint> points) {
  std::int64_t of_use = 0;
  std::uint32_t first_ns = std::numeric_limits<std::uint32_t>::max(), last_ns = 0;
  for (const LidarPoint& point : points) {
    if (!is_of_use(point)) continue;
    ++of_use;
    first_ns = std::min(first_ns, point.offset_ns);
    last_ns = std::max(last_ns, point.offset_ns);
  }
  const bool has_points = of_use > 0;
  if (!has_points && ++without_points_ == 1) first_without_points_ = scan.file.string();
  if (has_points) widest_ns_ = std::max(widest_ns_, std::int64_t{last_ns} - first_ns);
  const bool is_same =
      has_points && std::equal(points.begin(), points.end(), last_.begin(), last_.end(), is_same_place);
  repeats_.add(std::ssize(is_of_an_instant_), is_same);
  is_of_an_instant_.push_back(of_use > 1 && first_ns == last_ns);
  last_ = std::move(points);
}

std::vector<std::string> ScanWatch::faults(double rate_hz) const {
  std::vector<std::string> faults;
  if (without_points_ > 0)
    faults.push_back(fmt::format(
        "{} of {} scans hold no point of use, the first {}: none, or all are empty "
        "returns (0, 0, 0), no numbers, or not from {} to {} m away",
        without_points_, is_of_an_instant_.size(), first_without_points_, min_range_m_, max_range_m_));
  if (const auto runs = repeats_.text())
    faults.push_back(fmt::format("scans {} hold the same points, as of a driver that froze", *runs));
  if (const auto fault = point_times_fault(widest_ns_, rate_hz)) faults.push_back(*fault);
  return faults;
}

std::optional<std::string> scan_gap(const Sequence& sequence) {
  const std::vector<std::int64_t> stamps_ns = stamps_of(sequence.scans);
  std::vector<std::int64_t> steps_ns;
  for (std::size_t i = 1; i < stamps_ns.size(); ++i) steps_ns.push_back(stamps_ns[i] - stamps_ns[i - 1]);
  if (steps_ns.empty()) return std::nullopt;
  const auto longest = std::max_element(steps_ns.begin(), steps_ns.end()) - steps_ns.begin();
  const double usual_ns = static_cast<double>(upper_median(steps_ns)), most_ns = kGap * usual_ns;
  const auto gaps = std::count_if(steps_ns.begin(), steps_ns.end(), [&](std::int64_t step_ns) {
    return static_cast<double>(step_ns) > most_ns;
  });
  if (gaps == 0) return std::nullopt;
  std::string text =
      fmt::format("no scan for {:.4g} s after {} s, where one comes every {:.4g} s",
                  seconds(0, steps_ns[longest]), format_stamp(stamps_ns[longest]), 1e-9 * usual_ns);
  if (gaps > 1) text += fmt::format(" (the longest of {} such gaps)", gaps);
  return text;
}

}  // namespace uniquadric
