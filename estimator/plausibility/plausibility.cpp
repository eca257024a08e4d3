#include "estimator/plausibility/plausibility.h"

#include <iterator>

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
    for (const auto& text : {gyroscope_suspicion(*sequence.imu, samples, turns), gravity_suspicion(*sequence.imu, samples)})
      if (text) found.push_back((sequence.folder / "imu.csv").string() + ": " + *text);
  } catch (const InputError&) {  // is told by who checks the file
  }
  return found;
}

}  // namespace

std::vector<std::string> suspicions(const Sequence& sequence, const PlausibilityOptions& options) {
  std::vector<std::string> found;
  if (!options.enabled) return found;
  const auto add = [&](std::vector<std::string> more) {
    std::move(more.begin(), more.end(), std::back_inserter(found));
  };
  add(stamp_suspicions(sequence));
  const std::vector<FramePair> pairs = frame_pairs(sequence, options.pairs);
  add(intrinsic_suspicions(sequence, pairs));
  add(depth_form_suspicions(sequence, pairs));
  add(given_pose_suspicions(sequence, pairs));
  add(imu_suspicions(sequence, turns_of(sequence, pairs)));
  const ScanMotion scans = scan_motion(sequence);
  add(scans.faults);
  add(given_pose_suspicions(sequence, scans.pairs));
  add(scan_turn_suspicions(sequence, scans));
  add(repeat_suspicions(sequence, pairs));
  add(edge_suspicions(sequence, options.pairs / 2));
  return found;
}

}  // namespace uniquadric
