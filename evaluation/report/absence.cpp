#include "evaluation/report/absence.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <iterator>
#include <map>
#include <opencv2/core.hpp>

namespace uniquadric {
namespace {

constexpr std::int64_t kSameStamp_ns = 10'000'000;  // SPEC: poses belong together within 0.01 s
constexpr double kHiddenFraction = 0.1;             // below, an object is called hidden

// Whether the last thing that the track said is that it is lost.
bool is_lost_at(const ObjectTrack& track, std::int64_t stamp_ns) {
  const auto later = std::find_if(track.states.begin(), track.states.end(), [&](const ObjectState& state) {
    return state.stamp_ns > stamp_ns + kSameStamp_ns;
  });
  return later != track.states.begin() && std::prev(later)->status == ObjectStatus::lost;
}

// Empty when there is nothing to say of the track.
std::string track_note(const ObjectTrack& track, std::int64_t stamp_ns, bool has_masks, int mask_px) {
  if (state_at(track, stamp_ns) || track.states.empty()) return "";
  if (mask_px > 0) return fmt::format("{}: no state from a mask of {} px", label_of(track), mask_px);
  if (is_lost_at(track, stamp_ns)) return label_of(track) + ": lost";
  if (stamp_ns < track.states.front().stamp_ns || stamp_ns > track.states.back().stamp_ns) return "";
  return label_of(track) + (has_masks ? ": no mask" : ": no masks in this frame");
}

}  // namespace

const ObjectState* state_at(const ObjectTrack& track, std::int64_t stamp_ns) {
  for (const ObjectState& state : track.states)
    if (std::abs(state.stamp_ns - stamp_ns) <= kSameStamp_ns && state.status != ObjectStatus::lost)
      return &state;
  return nullptr;
}

const Pose* camera_pose_at(const Trajectory& trajectory, std::int64_t stamp_ns) {
  const StampedPose* nearest = nullptr;
  for (const StampedPose& pose : trajectory)
    if (std::abs(pose.stamp_ns - stamp_ns) <= kSameStamp_ns &&
        (!nearest || std::abs(pose.stamp_ns - stamp_ns) < std::abs(nearest->stamp_ns - stamp_ns)))
      nearest = &pose;
  return nearest ? &nearest->pose : nullptr;
}

std::string label_of(const ObjectTrack& track) {
  return track.name.empty() ? fmt::format("#{}", track.id) : track.name;
}

std::vector<std::string> absence_notes(const Tracks& estimate, const cv::Mat& masks, std::int64_t frame,
                                       std::int64_t stamp_ns, const Tracks& truth,
                                       const VisibilityTable& visibility) {
  std::vector<std::string> notes;
  if (!camera_pose_at(estimate.camera, stamp_ns)) notes.push_back("no camera pose");
  std::map<int, int> pixels = count_ids(masks);
  for (const ObjectTrack& track : estimate.objects) {
    const auto found = pixels.find(track.id);
    const int mask_px = found == pixels.end() ? 0 : found->second;
    if (found != pixels.end()) pixels.erase(found);
    const std::string note = track_note(track, stamp_ns, !masks.empty(), mask_px);
    if (!note.empty()) notes.push_back(note);
  }
  for (const auto& [id, count] : pixels)
    notes.push_back(fmt::format("#{}: never a state; mask of {} px", id, count));
  for (const ObjectTrack& object : truth.objects) {
    const auto seen = visibility.find({frame, object.id});
    if (seen == visibility.end() || seen->second.visible_fraction >= kHiddenFraction) continue;
    notes.push_back(label_of(object) + (seen->second.silhouette_px == 0
                                            ? " (truth): out of view"
                                            : fmt::format(" (truth): hidden, {:.0f} % seen",
                                                          100 * seen->second.visible_fraction)));
  }
  return notes;
}

}  // namespace uniquadric
