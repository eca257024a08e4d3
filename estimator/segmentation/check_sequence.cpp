#include "estimator/segmentation/check_sequence.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.h"

namespace uniquadric {
namespace {

std::string pose_span(const Sequence& sequence, const std::map<std::int64_t, Pose>& poses) {
  const auto& frames = sequence.frames;
  return fmt::format("no frame has a camera pose: camera_given.tum spans {}..{} s, the frames {}..{} s",
                     format_stamp(poses.begin()->first), format_stamp(poses.rbegin()->first),
                     format_stamp(frames.front().stamp_ns), format_stamp(frames.back().stamp_ns));
}

}  // namespace

void check_sequence(const Sequence& sequence, const PromptedSegmenter& segmenter,
                    const std::optional<std::map<std::int64_t, Pose>>& poses, bool by_lidar,
                    bool wants_images) {
  const auto& frames = sequence.frames;
  const auto has_image = [](const SequenceFrame& frame) { return !frame.depth.empty(); };
  if (wants_images && std::none_of(frames.begin(), frames.end(), has_image))
    throw InputError(sequence.folder / "depth.txt",
                     "no frame has a depth image, which the variant (depth: images) needs");
  if (by_lidar) return;
  const auto has_depth = [&](const SequenceFrame& frame) {
    return has_image(frame) || (poses && sequence.lidar);
  };
  const auto has_pose = [&](const SequenceFrame& frame) { return !poses || poses->contains(frame.stamp_ns); };
  const auto has_masks = [&](const SequenceFrame& frame) { return has_something_for(segmenter, frame); };
  if (std::none_of(frames.begin(), frames.end(), has_depth))
    throw InputError(sequence.folder,
                     sequence.scans.empty()
                         ? "no frame has depth"
                         : "no frame has a depth image; LiDAR scans need ego: lidar or given");
  if (std::none_of(frames.begin(), frames.end(), has_pose))
    throw InputError(sequence.folder, pose_span(sequence, *poses));
  if (std::none_of(frames.begin(), frames.end(), has_masks))
    throw InputError(sequence.folder, segmenter.source == kSequenceMasks ? "no frame has masks"
                                      : segmenter.prompt_kind == PromptKind::boxes
                                          ? "no frame has masks: the prompts hold no box"
                                          : "no frame has masks: the prompts hold no point");
  const auto has_all = [&](const auto& frame) {
    return has_depth(frame) && has_pose(frame) && has_masks(frame);
  };
  if (std::none_of(frames.begin(), frames.end(), has_all))
    throw InputError(sequence.folder, poses ? "no frame has depth, masks and a camera pose at once"
                                            : "no frame has both depth and masks");
}

}  // namespace uniquadric
