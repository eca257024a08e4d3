#include <algorithm>
#include <cassert>
#include <cmath>

#include "simulator/lidar/depth_octree.h"

namespace uniquadric {
namespace {

bool is_before(const LidarPoint& a, const LidarPoint& b) {
  return a.offset_ns != b.offset_ns ? a.offset_ns < b.offset_ns : a.ring < b.ring;
}

// Both scans list their points in firing order.
std::vector<double> errors_of(const LidarScan& compared, const LidarScan& reference,
                              RangeComparison& result) {
  std::vector<double> errors;
  std::size_t i = 0, j = 0;
  while (i < compared.points.size() || j < reference.points.size()) {
    ++result.beams;
    if (j == reference.points.size() ||
        (i < compared.points.size() && is_before(compared.points[i], reference.points[j]))) {
      ++result.extra;
      ++i;
    } else if (i == compared.points.size() || is_before(reference.points[j], compared.points[i])) {
      ++result.lost;
      ++j;
    } else {
      errors.push_back(static_cast<double>(compared.truth[i++].range_m) -
                       static_cast<double>(reference.truth[j++].range_m));
    }
  }
  return errors;
}

}  // namespace

double RangeComparison::completeness() const {
  return matched + lost == 0 ? 1 : static_cast<double>(matched) / static_cast<double>(matched + lost);
}

RangeComparison compare_ranges(const LidarScan& compared, const LidarScan& reference, double cell_m,
                               int cells) {
  assert(compared.start_ns == reference.start_ns && cells > 0 && cell_m > 0);
  RangeComparison result;
  result.histogram.assign(static_cast<std::size_t>(cells), 0);
  std::vector<double> errors = errors_of(compared, reference, result);
  result.matched = static_cast<std::int64_t>(errors.size());
  if (errors.empty()) return result;
  double squares = 0;
  for (double& error : errors) {
    const double cell = std::floor(error / cell_m + cells / 2.0);
    ++result.histogram[static_cast<std::size_t>(std::clamp(cell, 0.0, cells - 1.0))];
    result.mean_m += error;
    squares += error * error;
    error = std::abs(error);
  }
  const double n = static_cast<double>(errors.size());
  result.mean_m /= n;
  result.rms_m = std::sqrt(squares / n);
  std::sort(errors.begin(), errors.end());
  result.median_abs_m = errors[errors.size() / 2];
  result.p95_abs_m = errors[errors.size() * 95 / 100];
  return result;
}

}  // namespace uniquadric
