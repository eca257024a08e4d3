#include "estimator/segmentation/prompt_watch.h"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/core.hpp>

#include "core/base/warning.h"
#include "core/sequence/trajectory.h"
#include "estimator/segmentation/depth_parts.h"

namespace uniquadric {
namespace {

constexpr std::size_t kMostFaults = 5;  // that are named one by one

std::string text_of(const PromptWatch::Placed& placed, bool with_id) {
  std::string text =
      fmt::format("({:g}, {:g}) at {} s", placed.point.u, placed.point.v, format_stamp(placed.stamp_ns));
  return with_id ? fmt::format("{} of object {}", text, placed.point.id) : text;
}

}  // namespace

void PromptWatch::expect(std::int64_t stamp_ns, int id, const std::string& name) {
  const std::lock_guard lock(mutex_);
  Expected& expected = expected_.try_emplace(key_of(stamp_ns, id), Expected{stamp_ns, name}).first->second;
  ++expected.count;
}

void PromptWatch::found(std::int64_t stamp_ns, int id) {
  const std::lock_guard lock(mutex_);
  if (const auto expected = expected_.find(key_of(stamp_ns, id)); expected != expected_.end())
    expected->second.found = true;
}

void PromptWatch::share(const Placed& first, const Placed& second) {
  for (const Placed& placed : {first, second}) found(placed.stamp_ns, placed.point.id);
  if (ids_last_) {
    const std::lock_guard lock(mutex_);
    if (!said_.insert(std::minmax(first.point.id, second.point.id)).second) return;
  }
  warn(fmt::format("{}: the points {} and {} lie on one mask, which is one object", prompts_.string(),
                   text_of(first, ids_last_), text_of(second, ids_last_)));
}

std::vector<std::string> PromptWatch::faults() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> lines;
  std::size_t more = 0;
  for (const auto& [key, expected] : expected_) {
    if (expected.found) continue;
    if (lines.size() == kMostFaults) {
      ++more;
      continue;
    }
    std::string line = fmt::format("{}: ", prompts_.string());
    if (ids_last_) line += fmt::format("object {}: ", key.second);
    const std::string first = fmt::format("{} at {} s", expected.name, format_stamp(expected.first_ns));
    line += expected.count == 1 ? fmt::format("the {} gave no mask", first)
                                : fmt::format("none of its {} prompts gave a mask, the first being the {}",
                                              expected.count, first);
    lines.push_back(line);
  }
  if (more > 0) lines.push_back(fmt::format("{}: {} more prompts gave no mask", prompts_.string(), more));
  return lines;
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
