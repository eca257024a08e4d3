#include "estimator/estimate_warnings.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "core/base/seconds.h"
#include "core/base/warning.h"
#include "core/sequence/calibration.h"
#include "core/sequence/depth_scale.h"
#include "estimator/plausibility/plausibility.h"

namespace uniquadric {
namespace {

constexpr double kLongGap_s = 1;  // without a camera pose, that is told

struct Gap {
  std::int64_t first_frame = 0, last_frame = 0;
  double duration_s = 0;
};

// The longest stretch of frames without a pose, from pose to pose, or the sequence's end.
Gap longest_gap(const std::vector<FrameInfo>& frames) {
  Gap longest;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (frames[i].world_from_camera) continue;
    const std::size_t first = i;
    while (i < frames.size() && !frames[i].world_from_camera) ++i;
    const double duration_s =
        seconds(frames[first > 0 ? first - 1 : 0].stamp_ns, frames[std::min(i, frames.size() - 1)].stamp_ns);
    if (duration_s > longest.duration_s) longest = {frames[first].frame, frames[i - 1].frame, duration_s};
  }
  return longest;
}

void warn_of_the_camera(const Perception& perception, bool has_images) {
  const Gap gap = longest_gap(perception.frames());
  if (gap.duration_s > kLongGap_s)
    warn(fmt::format("the {} has no pose for {:.1f} s ({} {} to {})", has_images ? "camera" : "LiDAR",
                     gap.duration_s, has_images ? "frames" : "scans", gap.first_frame, gap.last_frame));
  if (const int restarts = perception.ego_restarts(); restarts > 0)
    warn(
        fmt::format("the camera lost its map {} times, and went on with a new one from the last known pose "
                    "(run.yaml: ego_restarts)",
                    restarts));
}

}  // namespace

void warn_of_the_calibration(const Sequence& sequence) {
  std::vector<std::string> faults = calibration_faults(sequence.camera);
  if (const auto fault = depth_scale_fault(sequence)) faults.push_back(*fault);
  for (const std::string& fault : faults)
    warn(fmt::format("{}: {}", (sequence.folder / "sequence.yaml").string(), fault));
}

void warn_of_suspicions(Sequence sequence, const Variant& variant, const EstimateOptions& run) {
  if (!run.perception.empty() && std::filesystem::exists(run.perception)) return;
  const LidarEgoOptions& lidar = variant.perception.lidar;
  if (!lidar.odometry.use_imu || lidar.imu_time_offset_ns != 0) sequence.imu.reset();
  PlausibilityOptions options = variant.plausibility;
  options.scans = false;
  for (const std::string& suspicion : suspicions(sequence, options)) warn(suspicion);
}

void warn_of_little(const Perception& perception, const Tracks& tracks, bool has_images, bool wants_objects) {
  const std::size_t frames = perception.frames().size(), lost = frames - tracks.camera.size();
  const auto never = static_cast<std::size_t>(
      std::ranges::count_if(perception.frames(), [](const auto& frame) { return !frame.world_from_camera; }));
  if (!has_images && lost > 0)
    warn(fmt::format("{} of {} scans have no pose (run.yaml: frames_without_pose)", lost, frames));
  if (has_images && 2 * lost > frames)
    warn(
        fmt::format("{} of {} frames have no camera pose{} (run.yaml: frames_without_pose)", lost, frames,
                    lost == never ? "" : fmt::format(" when they are seen, {} have none at the end", never)));
  warn_of_the_camera(perception, has_images);
  if (wants_objects && tracks.objects.empty())
    warn(fmt::format("no object has a state (run.yaml counts {})",
                     has_images ? "masks, depth and poses" : "poses"));
}

}  // namespace uniquadric
