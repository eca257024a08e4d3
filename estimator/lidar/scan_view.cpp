#include "estimator/lidar/scan_view.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

namespace uniquadric {

void NearestRange::Cell::add(const Entry& entry) {
  if (entry.cluster == two[0].cluster)
    two[0].range_m = std::min(two[0].range_m, entry.range_m);
  else if (entry.range_m < two[0].range_m)
    two = {entry, two[0]};
  else if (entry.range_m < two[1].range_m)
    two[1] = entry;
}

NearestRange::NearestRange(const ScanPoints& points, const std::optional<GroundPlane>& ground,
                           double ground_m, const std::vector<int>& cluster_of, double cell_rad)
    : cell_rad_(cell_rad), around_(static_cast<int>(std::ceil(2 * std::numbers::pi / cell_rad))) {
  for (std::size_t i = 0; i < points.bearings.size(); ++i)
    if (!ground || ground->height_of(points.world.col(static_cast<Eigen::Index>(i))) >= ground_m)
      cells_[cell_of(points.bearings[i])].add({points.ranges_m[i], cluster_of[i]});
}

std::pair<int, int> NearestRange::cell_of(const Bearing& bearing) const {
  const auto cell = [&](double angle) { return static_cast<int>(std::floor(angle / cell_rad_)); };
  return {(cell(bearing.x) + around_) % around_, cell(bearing.y)};
}

float NearestRange::around(const Bearing& bearing, int but) const {
  const auto [column, row] = cell_of(bearing);
  float least = kFar;
  for (int x = -1; x <= 1; ++x) {
    const auto cell = cells_.find({(column + x + around_) % around_, row});
    if (cell == cells_.end()) continue;
    for (const Entry& entry : cell->second.two)
      if (entry.cluster != but) least = std::min(least, entry.range_m);
  }
  return least;
}

void SensorView::widen(const std::vector<Bearing>& bearings) {
  constexpr float kClosed_rad = 6;
  std::vector<Bearing> all = hull_;
  all.insert(all.end(), bearings.begin(), bearings.end());
  if (all.empty()) return;
  cv::convexHull(all, hull_);
  const auto [left, right] = std::minmax_element(
      hull_.begin(), hull_.end(), [](const Bearing& a, const Bearing& b) { return a.x < b.x; });
  is_closed_ = right->x - left->x > kClosed_rad;
}

bool SensorView::is_at_rim(const Bearing& bearing, double rim_rad) const {
  if (hull_.size() < 3) return true;
  Bearing inside = bearing;  // the hull is nearly a rectangle where it is closed
  if (is_closed_) inside.x = 0;
  return cv::pointPolygonTest(hull_, inside, true) < rim_rad;
}

}  // namespace uniquadric
