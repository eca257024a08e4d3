#include "evaluation/camera_evaluation.h"

#include <set>

#include "core/sequence/stamps.h"
#include "evaluation/association/stamps.h"

namespace uniquadric {

PoseStatistics pose_statistics(const std::vector<PoseError>& errors) {
  return {statistics(translations_m(errors)), statistics(rotations_rad(errors))};
}

CameraEvaluation evaluate_camera(const Trajectory& truth, const Trajectory& estimate,
                                 std::int64_t max_difference_ns) {
  PosePairs poses;
  std::set<std::size_t> covered;
  std::vector<IndexStep> steps;  // a hole of either side is none
  const std::vector<bool> is_next = are_next_frames(stamps_of(truth));
  std::size_t last = 0;
  for (const IndexPair& pair :
       associate(stamps_of(truth), stamps_of(estimate), {StampRule::nearest, max_difference_ns})) {
    const std::size_t k = poses.size();
    if (k > 0 && pair.reference == last + 1 && is_next[pair.reference]) steps.push_back({k - 1, k});
    last = pair.reference;
    poses.stamps_ns.push_back(truth[pair.reference].stamp_ns);
    poses.reference.push_back(truth[pair.reference].pose);
    poses.estimate.push_back(estimate[pair.estimate].pose);
    covered.insert(pair.reference);
  }
  CameraEvaluation result;
  result.truth_poses = truth.size();
  result.pairs = poses.size();
  if (!truth.empty())
    result.coverage = static_cast<double>(covered.size()) / static_cast<double>(truth.size());
  if (result.pairs < kMinPairs) return result;
  result.ape = pose_statistics(absolute_errors(poses));
  result.rpe = pose_statistics(relative_errors(poses, steps));
  result.drift = maximum_drift(poses);
  return result;
}

}  // namespace uniquadric
