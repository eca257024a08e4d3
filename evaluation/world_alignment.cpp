#include "evaluation/world_alignment.h"

#include <algorithm>

#include "core/sequence/stamps.h"
#include "evaluation/association/stamps.h"
#include "evaluation/image_overlap.h"
#include "evaluation/trajectory/trajectory_error.h"

namespace uniquadric {

double object_distance_m(const Tracks& truth) {
  double sum_m = 0;
  std::size_t count = 0;
  for (const ObjectTrack& object : truth.objects)
    for (const ObjectState& state : object.states)
      if (const Pose* camera = nearest_pose(truth.camera, state.stamp_ns, 0)) {
        sum_m += (state.ellipsoid.world_from_object.translation - camera->translation).norm();
        ++count;
      }
  return count > 0 && sum_m > 0 ? sum_m / static_cast<double>(count) : 1;
}

WorldAlignment align_world(AlignmentKind kind, const Tracks& truth, const Tracks& estimate,
                           std::int64_t max_difference_ns) {
  std::vector<Pose> reference, estimated;
  for (const IndexPair& pair : associate(stamps_of(truth.camera), stamps_of(estimate.camera),
                                         {StampRule::nearest, max_difference_ns})) {
    reference.push_back(truth.camera[pair.reference].pose);
    estimated.push_back(estimate.camera[pair.estimate].pose);
  }
  WorldAlignment result{kind, {}, object_distance_m(truth)};
  // Nothing to align, and no rounding of a fit: a perfect estimate has no error at all.
  if (std::equal(reference.begin(), reference.end(), estimated.begin(), same_pose)) return result;
  if (reference.size() >= kMinPairs)
    result.truth_from_estimate = align(kind, reference, estimated, result.lever_m);
  return result;
}

Tracks in_true_world(const WorldAlignment& alignment, const Tracks& estimate) {
  if (alignment.kind == AlignmentKind::none) return estimate;
  Tracks moved = estimate;
  const double scale = alignment.truth_from_estimate.scale;
  for (StampedPose& pose : moved.camera) pose.pose = alignment.truth_from_estimate * pose.pose;
  for (ObjectTrack& object : moved.objects)
    for (ObjectState& state : object.states) {
      state.ellipsoid.world_from_object = alignment.truth_from_estimate * state.ellipsoid.world_from_object;
      state.ellipsoid.semi_axes_m *= scale;
      state.covariance_diagonal.head<6>() *= scale * scale;  // semi-axes, translation
    }
  return moved;
}

}  // namespace uniquadric
