#include "evaluation/association/object_overlap.h"

#include <algorithm>
#include <cstdlib>
#include <numeric>

#include "core/base/hungarian.h"
#include "evaluation/iou/ellipsoid_iou.h"

namespace uniquadric {
namespace {

using Presence = std::vector<std::optional<std::size_t>>;

// Stamps of the states that claim to see the object, and their indices.
struct Seen {
  std::vector<std::int64_t> stamps_ns;
  std::vector<std::size_t> states;
};
Seen seen_states(const ObjectTrack& track) {
  Seen seen;
  for (std::size_t i = 0; i < track.states.size(); ++i) {
    if (track.states[i].status == ObjectStatus::lost) continue;
    seen.stamps_ns.push_back(track.states[i].stamp_ns);
    seen.states.push_back(i);
  }
  return seen;
}

void sort_unique(std::vector<std::int64_t>& stamps) {
  std::sort(stamps.begin(), stamps.end());
  stamps.erase(std::unique(stamps.begin(), stamps.end()), stamps.end());
}

std::vector<std::int64_t> frame_stamps(const Tracks& truth, std::int64_t max_difference_ns) {
  std::vector<std::int64_t> stamps;
  for (const auto& object : truth.objects)
    for (const auto& state : object.states) stamps.push_back(state.stamp_ns);
  sort_unique(stamps);
  const std::vector<std::int64_t> of_objects = stamps;
  for (const auto& pose : truth.camera)
    if (of_objects.empty() ||
        std::abs(of_objects[nearest_index(of_objects, pose.stamp_ns)] - pose.stamp_ns) > max_difference_ns)
      stamps.push_back(pose.stamp_ns);
  sort_unique(stamps);
  return stamps;
}

Presence presence(const ObjectTrack& track, const std::vector<std::int64_t>& stamps_ns,
                  const StampOptions& options) {
  const Seen seen = seen_states(track);
  Presence result(stamps_ns.size());
  for (const IndexPair& pair : associate(stamps_ns, seen.stamps_ns, options))
    result[pair.reference] = seen.states[pair.estimate];
  return result;
}

}  // namespace

ObjectOverlaps overlap_objects(const Tracks& truth, const Tracks& estimate, std::int64_t max_difference_ns) {
  const StampOptions options{StampRule::one_to_one, max_difference_ns};
  ObjectOverlaps result;
  result.stamps_ns = frame_stamps(truth, max_difference_ns);
  const std::size_t frames = result.stamps_ns.size();
  for (const auto& object : truth.objects)
    result.truth.push_back(presence(object, result.stamps_ns, options));
  for (const auto& track : estimate.objects)
    result.estimate.push_back(presence(track, result.stamps_ns, options));
  for (std::size_t g = 0; g < truth.objects.size(); ++g) {
    auto& row = result.iou3d.emplace_back();
    for (std::size_t e = 0; e < estimate.objects.size(); ++e) {
      auto& values = row.emplace_back(frames, 0.0);
      for (std::size_t f = 0; f < frames; ++f) {
        const auto i = result.truth[g][f], j = result.estimate[e][f];
        if (i && j)
          values[f] =
              ellipsoid_iou(truth.objects[g].states[*i].ellipsoid, estimate.objects[e].states[*j].ellipsoid);
      }
    }
  }
  return result;
}

std::vector<std::optional<std::size_t>> match_objects(const ObjectOverlaps& overlaps) {
  std::vector<std::optional<std::size_t>> matches(overlaps.truth.size());
  if (overlaps.truth.empty() || overlaps.estimate.empty()) return matches;
  Eigen::MatrixXd sums(overlaps.truth.size(), overlaps.estimate.size());
  for (Eigen::Index g = 0; g < sums.rows(); ++g)
    for (Eigen::Index e = 0; e < sums.cols(); ++e) {
      const auto& values = overlaps.iou3d[static_cast<std::size_t>(g)][static_cast<std::size_t>(e)];
      sums(g, e) = std::accumulate(values.begin(), values.end(), 0.0);
    }
  const std::vector<int> assignment = maximum_assignment(sums);
  for (std::size_t g = 0; g < matches.size(); ++g)
    if (assignment[g] >= 0 && sums(static_cast<Eigen::Index>(g), assignment[g]) > 0)
      matches[g] = static_cast<std::size_t>(assignment[g]);
  return matches;
}

}  // namespace uniquadric
