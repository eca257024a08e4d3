#include "estimator/plausibility/plausibility.h"

#include <iterator>

#include "estimator/plausibility/edge_alignment.h"
#include "estimator/plausibility/frame_pairs.h"
#include "estimator/plausibility/given_poses.h"
#include "estimator/plausibility/repeated_images.h"
#include "estimator/plausibility/stamp_checks.h"

namespace uniquadric {

std::vector<std::string> suspicions(const Sequence& sequence, const PlausibilityOptions& options) {
  std::vector<std::string> found;
  if (!options.enabled) return found;
  const auto add = [&](std::vector<std::string> more) {
    std::move(more.begin(), more.end(), std::back_inserter(found));
  };
  add(stamp_suspicions(sequence));
  const std::vector<FramePair> pairs = frame_pairs(sequence, options.pairs);
  add(given_pose_suspicions(sequence, pairs));
  add(repeat_suspicions(sequence, pairs));
  add(edge_suspicions(sequence, options.pairs / 2));
  return found;
}

}  // namespace uniquadric
