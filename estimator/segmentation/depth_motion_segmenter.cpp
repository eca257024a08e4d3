// Parts of depth: everything that moves, or what is at points.
#include <opencv2/imgproc.hpp>
#include <vector>

#include "core/base/warning.h"
#include "estimator/features/frame_pair.h"
#include "estimator/segmentation/depth_parts.h"
#include "estimator/segmentation/moving_parts.h"
#include "estimator/segmentation/segmenter.h"

namespace uniquadric {
namespace {

constexpr int kEarlierImages = 6;  // a second at 30 Hz, for slow bodies to move

// The frame so many before; nothing at the start and where there is no depth.
const SequenceFrame* frame_before(const Sequence& sequence, const SegmenterInput& input, int frames) {
  if (input.frame.frame < frames) return nullptr;
  const SequenceFrame& earlier = sequence.frames[input.frame.frame - frames];
  return earlier.depth.empty() ? nullptr : &earlier;
}

FrameImages frame_images(const cv::Mat& rgb, const cv::Mat& depth) {
  FrameImages images{{}, depth};
  cv::cvtColor(rgb, images.gray, cv::COLOR_BGR2GRAY);
  return images;
}

// Earlier images, `frames` apart from each other, as far back as the camera's motion is known.
std::vector<EarlierImages> earlier_images(const Sequence& sequence, const SegmenterInput& input,
                                          const FrameImages& now, int frames, RandomStream& random) {
  std::vector<EarlierImages> result;
  FrameImages later = now;
  std::vector<PointPair> points = corners_of(sequence.camera, now);
  for (int n = 1; n <= kEarlierImages; ++n) {
    const SequenceFrame* const frame = frame_before(sequence, input, n * frames);
    if (!frame) break;
    const FrameImages earlier = frame_images(read_rgb(sequence, *frame), read_depth(sequence, *frame));
    points = followed(sequence.camera, later, earlier, points);
    const auto motion = fit_motion(sequence.camera, points, random).b_from_a;
    if (!motion) break;
    result.push_back({earlier, *motion});
    later = earlier;
  }
  return result;
}

struct DepthMotionOptions {
  DepthPartsOptions parts;
  int frames = 5;  // from one of the earlier images to the next; ours
  // of what depth is off at a part's distance (median), to contradict that it stood still; 0: whatever stands
  // clear of planes is a body. Ours
  double ratio = 6;
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
    const cv::Mat parts = depth_parts(input.depth, camera, options_.parts, random);
    if (prompts.kind == PromptKind::points) return parts_at_points(parts, prompts.points);
    if (!(options_.ratio > 0)) return parts;
    const FrameImages now = frame_images(input.rgb, input.depth);
    const auto earlier = earlier_images(sequence, input, now, options_.frames, random);
    return moving_parts(parts, now, earlier, input.tracked, camera, options_.ratio);
  }

 private:
  DepthMotionOptions options_;
};

template <typename Io>
void visit(Io& io, DepthMotionOptions& options) {
  io.section("depth_parts", [&](auto& inner) { inner.positive("jump", options.parts.jump); });
  io.section("moving_parts", [&](auto& inner) {
    inner.number("frames", options.frames, 1, 1000);
    inner.number("ratio", options.ratio, 0.0, 1000.0);
  });
}

}  // namespace

SegmenterKind depth_motion_kind() {
  constexpr const char* kName = "depth_motion";
  SegmenterKind kind =
      segmenter_kind<DepthMotionSegmenter>(kName, {PromptKind::everything, PromptKind::points});
  kind.make = [=](const SegmentationOptions& options, PromptKind prompts) {
    const auto own = options.of<DepthMotionOptions>(kName);
    if (prompts == PromptKind::everything && own.ratio > 0)
      warn("without masks, prompts or a network only what moves against the background is found");
    return std::make_shared<DepthMotionSegmenter>(own);
  };
  return kind;
}

}  // namespace uniquadric
