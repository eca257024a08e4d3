// Parts of depth: everything that moves, or what is at points.
#include <opencv2/core.hpp>
#include <vector>

#include "core/base/warning.h"
#include "estimator/features/frame_pair.h"
#include "estimator/segmentation/depth_parts.h"
#include "estimator/segmentation/moving_parts.h"
#include "estimator/segmentation/segmenter.h"

namespace uniquadric {
namespace {

constexpr std::size_t kEarlierImages = 6;  // a second at 30 Hz, for slow bodies to move
constexpr std::size_t kLeastImages = 2;    // that moving_parts needs
constexpr double kLeastFollowed = 0.4;     // of the corners: fewer may all be a body's

// Earlier images, `frames` apart from each other, as far back as the camera's motion is known. Those without
// depth are left out.
std::vector<EarlierImages> earlier_images(const Sequence& sequence, const SegmenterInput& input,
                                          const FrameImages& now, int frames, RandomStream& random) {
  std::vector<EarlierImages> result;
  FrameImages later = now;
  std::vector<PointPair> points = corners_of(sequence.camera, now);
  const double least = kLeastFollowed * static_cast<double>(points.size());
  for (auto n = input.frame.frame - frames; n >= 0 && result.size() < kEarlierImages; n -= frames) {
    const SequenceFrame& frame = sequence.frames[n];
    if (frame.depth.empty()) continue;
    const FrameImages earlier = frame_images(read_rgb(sequence, frame), read_depth(sequence, frame));
    points = followed(sequence.camera, later, earlier, points);
    const auto motion = fit_motion(sequence.camera, points, random).b_from_a;
    if (!motion || static_cast<double>(points.size()) < least) break;
    result.push_back({earlier, *motion});
    later = earlier;
  }
  return result;
}

struct DepthMotionOptions {
  DepthPartsOptions parts;
  int frames = 5;  // from one of the earlier images to the next; ours
  // a part moved where depth lies behind it by more than this many median errors at its distance; 0: whatever
  // stands clear of planes is a body. Ours
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
    if (!(options_.ratio > 0) || cv::countNonZero(parts) == 0) return parts;
    const FrameImages now = frame_images(input.rgb, input.depth);
    // A fast turn is followed over fewer frames.
    std::vector<EarlierImages> earlier;
    for (int frames = options_.frames; frames > 0 && earlier.size() < kLeastImages; frames /= 2)
      earlier = earlier_images(sequence, input, now, frames, random);
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
