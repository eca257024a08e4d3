#include "estimator/perception/perceive.h"

#include <memory>

#include "core/base/error.h"
#include "core/base/warning.h"
#include "estimator/lidar/scan_watch.h"
#include "estimator/perception/frame_pipeline.h"
#include "estimator/perception/image_stages.h"

namespace uniquadric {
namespace {

// That of a sequence with images, as slow as it is. It reads the images that it needs, which nothing else
// does where bodies come from scans.
std::unique_ptr<SegmenterClock> clock_of(const PromptedSegmenter& segmenter, const Sequence& sequence,
                                         const PerceptionOptions& options, const PerceiveOptions& run) {
  SlowSegmenter slow = slow_segmenter(sequence, segmenter, options.aot, run.seed);
  slow.segment = [&sequence, segmenter, seed = run.seed](const SegmenterInput& input) {
    const SequenceFrame& frame = input.frame;
    const cv::Mat depth = frame.depth.empty() ? cv::Mat() : read_depth(sequence, frame);
    return segment(segmenter, sequence, frame, depth, seed);
  };
  return make_virtual_clock(std::move(slow));
}

void warn_of_gap(const Sequence& sequence) {
  if (const auto gap = scan_gap(sequence))
    warn(fmt::format("{}: {}", (sequence.folder / "lidar.txt").string(), *gap));
}

void pass_all_frames(ImageStages& stages, std::size_t frames, const PerceiveOptions& run,
                     std::vector<StageTime>& times) {
  std::size_t next = 0;
  const auto take = [&]() -> std::shared_ptr<FrameWork> {
    if (next == frames) return nullptr;
    auto work = std::make_shared<FrameWork>();
    work->index = next++;
    return work;
  };
  using enum FrameOrder;
  pass_frames<FrameWork>(run.threads, run.feedback ? 1 : kFramesInFlight, take,
                         {{at_once, [&](FrameWork& work) { stages.read(work); }},
                          {in_order, [&](FrameWork& work) { stages.check_depth(work); }},
                          {at_once, [&](FrameWork& work) { stages.segment_now(work); }},
                          {in_order, [&](FrameWork& work) { stages.carry_masks(work); }},
                          {in_order, [&](FrameWork& work) { stages.place_camera(work); }},
                          {at_once, [&](FrameWork& work) { stages.add_background_depth(work); }},
                          {in_order, [&](FrameWork& work) { stages.follow_features(work); }},
                          {at_once, [&](FrameWork& work) { stages.observe(work); }},
                          {in_order, [&](FrameWork& work) { stages.hand_over(work, times); }}});
}

void perceive_images(const Sequence& recorded, const PerceptionOptions& options, const PerceiveOptions& run,
                     PerceptionWriter& out, std::vector<StageTime>& times) {
  const ImageInput input = prepare_images(recorded, options, run, times);
  ImageStages stages(input, options, run, out);
  if (stages.reads_scans()) warn_of_gap(recorded);
  pass_all_frames(stages, input.sequence.frames.size(), run, times);
  stages.finish();
}

}  // namespace

Camera perception_camera(const Sequence& sequence, const PerceptionOptions& options) {
  return sequence.frames.empty() ? scan_camera(options.scan_objects) : without_distortion(sequence.camera);
}

void perceive(const Sequence& recorded, const PerceptionOptions& options, const PerceiveOptions& run,
              PerceptionWriter& out, std::vector<StageTime>& times) {
  if (!recorded.frames.empty() && options.images) return perceive_images(recorded, options, run, out, times);
  if (options.ego != EgoSource::lidar)
    throw InputError(recorded.folder, "has no images to go by: only `ego: {source: lidar}` can follow it");
  const Sequence sequence = on_camera_clock(recorded, options.lidar_time_offset_ns);
  warn_of_gap(recorded);
  PromptedSegmenter segmenter;
  std::unique_ptr<SegmenterClock> clock;
  if (options.scan_objects.masks && !sequence.frames.empty()) {
    segmenter = make_segmenter(sequence, options.segmentation, run.prompts);
    clock = clock_of(segmenter, sequence, options, run);
  }
  perceive_scans(sequence, options.lidar, options.scan_objects, clock.get(), run.seed, run.quiet, out, times);
  warn_of_prompts(segmenter);
}

}  // namespace uniquadric
