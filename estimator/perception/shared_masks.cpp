#include "estimator/perception/shared_masks.h"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/core.hpp>

#include "core/base/warning.h"
#include "core/sequence/trajectory.h"
#include "estimator/perception/depth_parts.h"

namespace uniquadric {
namespace {

std::string text_of(const SharedMasks::Placed& placed, bool with_id) {
  std::string text =
      fmt::format("({:g}, {:g}) at {} s", placed.point.u, placed.point.v, format_stamp(placed.stamp_ns));
  return with_id ? fmt::format("{} of object {}", text, placed.point.id) : text;
}

}  // namespace

void SharedMasks::say(const Placed& first, const Placed& second) {
  if (ids_last_) {
    const std::lock_guard lock(mutex_);
    if (!said_.insert(std::minmax(first.point.id, second.point.id)).second) return;
  }
  warn(fmt::format("{}: the points {} and {} lie on one mask, which is one object", prompts_.string(),
                   text_of(first, ids_last_), text_of(second, ids_last_)));
}

std::vector<std::pair<PointPrompt, PointPrompt>> points_on_one_mask(const cv::Mat& masks,
                                                                    const std::vector<PointPrompt>& points) {
  std::vector<std::pair<PointPrompt, PointPrompt>> pairs;
  if (masks.empty()) return pairs;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (cv::countNonZero(masks == points[i].id) > 0) continue;
    const int taken_by = label_near(masks, points[i]);
    const auto other = std::find_if(points.begin(), points.end(),
                                    [&](const PointPrompt& point) { return point.id == taken_by; });
    if (taken_by == 0 || other == points.end()) continue;
    if (static_cast<std::size_t>(other - points.begin()) < i)
      pairs.emplace_back(*other, points[i]);
    else
      pairs.emplace_back(points[i], *other);
  }
  return pairs;
}

}  // namespace uniquadric
