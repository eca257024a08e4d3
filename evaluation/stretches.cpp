#include "evaluation/stretches.h"

#include <cassert>
#include <cstdint>

#include "evaluation/object_presence.h"

namespace uniquadric {
namespace {

// Rows of other objects lie between: at most a look at each row of the frames between.
bool is_hidden_between(const VisibilityTable& visibility, int id, std::int64_t before, std::int64_t after) {
  const auto end = visibility.lower_bound({after, id});
  for (auto row = visibility.upper_bound({before, id}); row != end && row != visibility.end(); ++row)
    if (row->first.second == id && !is_visible(row->second)) return true;
  return false;
}

bool is_hidden(const ObjectFrame& frame, const std::optional<ObjectStatus>& status) {
  if (!frame.visible) return true;
  const bool is_seen = frame.visible_fraction && *frame.visible_fraction >= kOccludedFraction;
  return status == ObjectStatus::occluded && !is_seen;
}

}  // namespace

std::vector<StretchFrame> stretch_frames(int id, const std::vector<ObjectFrame>& frames,
                                         const std::vector<std::optional<ObjectStatus>>& statuses,
                                         const VisibilityTable& visibility) {
  assert(frames.size() == statuses.size());
  std::vector<StretchFrame> result;
  for (std::size_t k = 0; k < frames.size(); ++k)
    result.push_back({statuses[k].has_value(), is_hidden(frames[k], statuses[k]),
                      k > 0 && is_hidden_between(visibility, id, frames[k - 1].frame, frames[k].frame)});
  return result;
}

std::vector<std::size_t> later_stretch_starts(const std::vector<StretchFrame>& frames) {
  std::vector<std::size_t> starts;
  std::size_t states = 0;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    if (!frames[k].has_state) continue;
    const bool is_cut =
        k > 0 && (!frames[k - 1].has_state || frames[k - 1].is_hidden != frames[k].is_hidden ||
                  frames[k].was_hidden_before);
    if (is_cut && states > 0) starts.push_back(states);
    ++states;
  }
  return starts;
}

}  // namespace uniquadric
