#include "evaluation/false_bodies.h"

#include <algorithm>

namespace uniquadric {

int count_false_bodies(const std::vector<ObjectTrack>& estimate, const std::vector<int>& unmatched_ids) {
  const auto is_false = [&](const ObjectTrack& track) {
    return std::ranges::find(unmatched_ids, track.id) != unmatched_ids.end() &&
           std::ranges::any_of(track.states, [](const ObjectState& state) {
             return state.status == ObjectStatus::active || state.status == ObjectStatus::occluded;
           });
  };
  return static_cast<int>(std::ranges::count_if(estimate, is_false));
}

}  // namespace uniquadric
