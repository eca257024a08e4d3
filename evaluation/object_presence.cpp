#include "evaluation/object_presence.h"

#include <algorithm>
#include <cmath>

#include "core/sequence/stamps.h"
#include "evaluation/association/stamps.h"

namespace uniquadric {
namespace {

double longest_gap_s(const std::vector<ObjectFrame>& frames) {
  const std::vector<std::int64_t> stamps = stamps_of(frames);
  const std::int64_t period = median_period_ns(stamps);
  const std::vector<bool> is_next = are_next_frames(stamps);
  std::int64_t longest = 0, gap = 0;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    if (frames[k].estimate)
      gap = 0;
    else if (frames[k].visible)
      gap += k + 1 < frames.size() && is_next[k + 1] ? stamps[k + 1] - stamps[k] : period;
    longest = std::max(longest, gap);
  }
  return static_cast<double>(longest) * 1e-9;
}

}  // namespace

bool is_visible(const ObjectVisibility& visibility) {
  return visibility.visible_fraction >= kVisibleFraction && visibility.visible_px >= kVisible_px;
}

bool is_occluded(const ObjectVisibility& visibility) {
  return visibility.visible_fraction < kOccludedFraction;
}

std::optional<double> semi_axes_change_occluded(const std::vector<ObjectFrame>& frames) {
  std::optional<double> greatest;
  std::optional<Eigen::Vector3d> before_m;
  for (const ObjectFrame& frame : frames) {
    if (!frame.estimate) continue;
    const Eigen::Vector3d a = frame.names.cwiseAbs() * frame.estimate->semi_axes_m;
    if (!frame.occluded)
      before_m = a;
    else if (before_m)
      greatest =
          std::max(greatest.value_or(0), (a - *before_m).cwiseQuotient(*before_m).cwiseAbs().maxCoeff());
  }
  return greatest;
}

bool says_what_is_visible(const std::vector<ObjectFrame>& frames) {
  return std::ranges::any_of(frames, [](const ObjectFrame& f) { return f.visible_fraction.has_value(); });
}

std::vector<ObjectFrame> frames_in_view(const std::vector<ObjectFrame>& frames) {
  std::vector<ObjectFrame> seen;
  bool was_in_view = true;
  for (const ObjectFrame& frame : frames) {
    const bool is_in_view = frame.visible && frame.visible_fraction;
    if (is_in_view) seen.push_back(frame);
    if (is_in_view && !was_in_view) seen.back().rpe = seen.back().motion = std::nullopt;
    was_in_view = is_in_view;
  }
  return seen;
}

std::vector<ObjectFrame> frames_after_start(const std::vector<ObjectFrame>& frames) {
  const auto begin = frames.begin(), end = frames.end();
  const auto first = std::find_if(begin, end, [](const ObjectFrame& f) { return f.estimate.has_value(); });
  if (first == end) return {};
  const std::int64_t from_ns = first->stamp_ns + std::llround(kStart_s * 1e9);
  std::vector<ObjectFrame> late(
      std::find_if(first, end, [&](const ObjectFrame& f) { return f.stamp_ns >= from_ns; }), end);
  if (!late.empty()) late.front().rpe = late.front().motion = std::nullopt;
  return late;
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

std::vector<ObjectTrack> only_in_view(std::vector<ObjectTrack> truth, const VisibilityTable& visibility) {
  for (ObjectTrack& object : truth)
    std::erase_if(object.states, [&](const ObjectState& state) {
      const auto seen = visibility.find({state.frame, object.id});
      return seen != visibility.end() && !is_visible(seen->second);
    });
  return truth;
}

}  // namespace uniquadric
