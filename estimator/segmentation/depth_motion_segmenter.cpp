// Parts of depth, split by motion: everything that moves, or what is at points.
#include <map>
#include <optional>

#include "core/base/warning.h"
#include "estimator/segmentation/depth_parts.h"
#include "estimator/segmentation/motion_split.h"
#include "estimator/segmentation/moving_parts.h"
#include "estimator/segmentation/segmenter.h"

namespace uniquadric {
namespace {

// The images some frames earlier that a frame's motions are seen against, each read once.
class EarlierImages {
 public:
  EarlierImages(const Sequence& sequence, const SegmenterInput& input) : sequence_(sequence), input_(input) {}

  // Nothing at the start and where there is no depth.
  const std::optional<EarlierImage>& before(int frames) {
    const auto [entry, is_new] = images_.try_emplace(frames);
    if (is_new) entry->second = read(frames);
    return entry->second;
  }

 private:
  std::optional<EarlierImage> read(int frames) const {
    if (input_.frame.frame < frames) return std::nullopt;
    const SequenceFrame& earlier = sequence_.frames[input_.frame.frame - frames];
    if (earlier.depth.empty()) return std::nullopt;
    return with_flow({read_rgb(sequence_, earlier), read_depth(sequence_, earlier)},
                     {input_.rgb, input_.depth});
  }

  const Sequence& sequence_;
  const SegmenterInput& input_;
  std::map<int, std::optional<EarlierImage>> images_;
};

// The parts that are seen to move twice: once may be an error of the flow. Over as long as the background's
// motion is known: a fast turn leaves less time.
cv::Mat parts_that_move(const cv::Mat& parts, const Camera& camera, const MotionSplitOptions& options,
                        const SegmenterInput& input, EarlierImages& earlier) {
  const auto moving = [&](const cv::Mat& of, int frames) -> std::optional<cv::Mat> {
    const auto& before = earlier.before(frames);
    if (!before) return std::nullopt;
    return moving_parts(of, {input.rgb, input.depth}, *before, input.tracked, camera, options);
  };
  for (int frames = 2 * options.frames; frames > 1; frames /= 2)
    if (const auto once = moving(parts, frames)) {
      frames /= 2;
      if (const auto twice = moving(*once, frames)) return *twice;
    }
  return cv::Mat::zeros(parts.size(), CV_16UC1);
}

struct DepthMotionOptions {
  DepthPartsOptions parts;
  MotionSplitOptions motion;
};

class DepthMotionSegmenter final : public Segmenter {
 public:
  using Options = DepthMotionOptions;
  explicit DepthMotionSegmenter(const DepthMotionOptions& options) : options_(options) {}

  cv::Mat segment(const Sequence& sequence, const SegmenterInput& input, const FramePrompts& prompts,
                  std::uint64_t seed) const override {
    if (input.depth.empty()) return {};
    RandomStream random(seed, "depth_motion", input.frame.frame);
    const Camera& camera = sequence.camera;
    const MotionSplitOptions& motion = options_.motion;
    EarlierImages earlier(sequence, input);
    cv::Mat parts = depth_parts(input.depth, camera, options_.parts, random);
    if (const auto& before = earlier.before(motion.frames))
      parts = split_by_motion(parts, {input.rgb, input.depth}, *before, camera, motion, random);
    if (prompts.kind == PromptKind::points) return parts_at_points(parts, prompts.points);
    return motion.moving_ratio > 0 ? parts_that_move(parts, camera, motion, input, earlier) : parts;
  }

 private:
  DepthMotionOptions options_;
};

template <typename Io>
void visit(Io& io, DepthMotionOptions& options) {
  io.section("depth_parts", [&](auto& inner) { inner.positive("jump", options.parts.jump); });
  io.section("motion_split", [&](auto& inner) {
    inner.number("frames", options.motion.frames, 1, 1000);
    inner.number("samples", options.motion.samples, 10, 100'000);
    inner.number("moving_ratio", options.motion.moving_ratio, 0.0, 1000.0);
  });
}

}  // namespace

SegmenterKind depth_motion_kind() {
  constexpr const char* kName = "depth_motion";
  SegmenterKind kind =
      segmenter_kind<DepthMotionSegmenter>(kName, {PromptKind::everything, PromptKind::points});
  kind.make = [=](const SegmentationOptions& options, PromptKind prompts) {
    const auto own = options.of<DepthMotionOptions>(kName);
    if (prompts == PromptKind::everything && own.motion.moving_ratio > 0)
      warn("without masks, prompts or a network only what moves against the background is found");
    return std::make_shared<DepthMotionSegmenter>(own);
  };
  return kind;
}

}  // namespace uniquadric
