#include "estimator/plausibility/plausibility.h"

#include "estimator/plausibility/calibration_checks.h"
#include "estimator/plausibility/depth_forms.h"
#include "estimator/plausibility/edge_alignment.h"
#include "estimator/plausibility/frame_pairs.h"
#include "estimator/plausibility/given_poses.h"
#include "estimator/plausibility/imu_turns.h"
#include "estimator/plausibility/repeated_images.h"
#include "estimator/plausibility/scan_checks.h"
#include "estimator/plausibility/stamp_checks.h"

#include "core/base/error.h"

namespace uniquadric {
namespace {

std::vector<std::string> imu_suspicions(const Sequence& sequence, const std::vector<Turn>& turns) {
  if (!sequence.imu) return {};
  std::vector<std::string> found;
  try {
    const std::vector<ImuSample> samples = read_imu_csv(sequence.folder / "imu.csv");
    for (const auto& text :
         {gyroscope_suspicion(*sequence.imu, samples, turns), gravity_suspicion(*sequence.imu, samples)})
      if (text) found.push_back((sequence.folder / "imu.csv").string() + ": " + *text);
  } catch (const InputError&) {  // is told by who checks the file
  }
  return found;
}

// What is wrong with the depth or the intrinsics; the first test that says so, for the others follow from it.
std::vector<std::string> depth_suspicions(const Sequence& sequence, const std::vector<FramePair>& pairs,
                                          const PlausibilityOptions& options) {
  std::vector<std::string> found = repeated_depth_suspicions(sequence, pairs);
  if (found.empty()) found = edge_suspicions(sequence, EdgesOf::depth, options.pairs / 2);
  if (found.empty()) found = intrinsic_suspicions(sequence, pairs);
  if (found.empty()) found = depth_form_suspicions(sequence, pairs);
  return found;
}

// Poses are compared with scans that turn as the IMU does, or where there is none.
std::vector<std::string> scan_suspicions(const Sequence& sequence) {
  const ScanMotion scans = scan_motion(sequence);
  if (!scans.faults.empty()) return scans.faults;
  std::vector<std::string> found = scan_turn_suspicions(sequence, scans);
  if (found.empty()) found = given_pose_suspicions(sequence, scans.pairs);
  return found;
}

}  // namespace

std::vector<std::string> suspicions(const Sequence& sequence, const PlausibilityOptions& options) {
  std::vector<std::string> found;
  if (!options.enabled) return found;
  const auto add = [&](const std::vector<std::string>& more) {
    found.insert(found.end(), more.begin(), more.end());
    return !more.empty();
  };
  add(stamp_suspicions(sequence));
  add(edge_suspicions(sequence, EdgesOf::masks, options.pairs / 2));
  const std::vector<FramePair> pairs = frame_pairs(sequence, options.pairs);
  add(repeated_mask_suspicions(sequence, pairs));
  // The motion by depth is right only if the depth and the intrinsics are.
  if (!add(depth_suspicions(sequence, pairs, options))) {
    add(given_pose_suspicions(sequence, pairs));
    add(imu_suspicions(sequence, turns_of(sequence, pairs)));
  }
  if (options.scans) add(scan_suspicions(sequence));
  return found;
}

}  // namespace uniquadric
