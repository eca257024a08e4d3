#include "evaluation/object_presence.h"

#include <algorithm>

namespace uniquadric {
namespace {

std::int64_t median_period_ns(const std::vector<ObjectFrame>& frames) {
  std::vector<std::int64_t> periods;
  for (std::size_t k = 1; k < frames.size(); ++k)
    periods.push_back(frames[k].stamp_ns - frames[k - 1].stamp_ns);
  if (periods.empty()) return 0;
  const auto middle = periods.begin() + std::ssize(periods) / 2;
  std::nth_element(periods.begin(), middle, periods.end());
  return *middle;
}

double longest_gap_s(const std::vector<ObjectFrame>& frames) {
  const std::int64_t end = frames.back().stamp_ns + median_period_ns(frames);
  std::int64_t longest = 0, gap = 0;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    if (frames[k].estimate)
      gap = 0;
    else if (frames[k].visible)
      gap += (k + 1 < frames.size() ? frames[k + 1].stamp_ns : end) - frames[k].stamp_ns;
    longest = std::max(longest, gap);
  }
  return static_cast<double>(longest) * 1e-9;
}

}  // namespace

bool is_visible(const ObjectVisibility& visibility) {
  return visibility.visible_fraction >= kVisibleFraction && visibility.visible_px >= kVisible_px;
}

ObjectPresence object_presence(const std::vector<ObjectFrame>& frames) {
  ObjectPresence result;
  std::size_t estimated = 0, visible_and_estimated = 0;
  for (const ObjectFrame& frame : frames) {
    estimated += frame.estimate ? 1 : 0;
    result.visible_frames += frame.visible ? 1 : 0;
    visible_and_estimated += frame.visible && frame.estimate ? 1 : 0;
  }
  const auto share = [](std::size_t part, std::size_t whole) {
    return whole > 0 ? std::optional(static_cast<double>(part) / static_cast<double>(whole)) : std::nullopt;
  };
  result.coverage = share(visible_and_estimated, result.visible_frames);
  result.coverage_of_all_frames = share(estimated, frames.size());
  if (result.visible_frames > 0) result.longest_gap_s = longest_gap_s(frames);
  return result;
}

}  // namespace uniquadric
