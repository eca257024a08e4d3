// Boxes by GrabCut and depth: the user's, or a detector's.
#include <algorithm>
#include <opencv2/core.hpp>

#include "estimator/segmentation/box_detector.h"
#include "estimator/segmentation/grabcut_depth.h"
#include "estimator/segmentation/segmenter.h"

namespace uniquadric {
namespace {

constexpr const char* kGrabcut = "grabcut_depth";

// Where two objects claim a pixel the smaller box has it: it is more likely the one in front.
cv::Mat masks_of_boxes(std::vector<BoxPrompt> boxes, const GrabcutOptions& options, const Camera& camera,
                       const SegmenterInput& input, std::uint64_t seed) {
  if (boxes.empty() || input.depth.empty()) return {};
  std::stable_sort(boxes.begin(), boxes.end(),
                   [](const auto& a, const auto& b) { return a.width * a.height > b.width * b.height; });
  cv::Mat masks = cv::Mat::zeros(input.rgb.size(), CV_16UC1);
  for (const auto& box : boxes) {
    RandomStream random(seed, kGrabcut, input.frame.frame, box.id);
    masks.setTo(box.id, grabcut_depth(input.rgb, input.depth, camera, box, options, random));
  }
  return masks;
}

class GrabcutSegmenter final : public Segmenter {
 public:
  using Options = GrabcutOptions;
  explicit GrabcutSegmenter(const GrabcutOptions& options) : options_(options) {}

  cv::Mat segment(const Sequence& sequence, const SegmenterInput& input, const FramePrompts& prompts,
                  std::uint64_t seed) const override {
    return masks_of_boxes(prompts.boxes, options_, sequence.camera, input, seed);
  }

 private:
  GrabcutOptions options_;
};

class DetectorSegmenter final : public Segmenter {
 public:
  using Options = DetectorOptions;
  explicit DetectorSegmenter(const DetectorOptions& options, const GrabcutOptions& grabcut = {})
      : options_(options), grabcut_(grabcut), model_(options.model) {}

  cv::Mat segment(const Sequence& sequence, const SegmenterInput& input, const FramePrompts& /*prompts*/,
                  std::uint64_t seed) const override {
    return masks_of_boxes(detect_boxes(model_, input.rgb, options_), grabcut_, sequence.camera, input, seed);
  }

 private:
  DetectorOptions options_;
  GrabcutOptions grabcut_;
  OnnxModel model_;
};

}  // namespace

template <typename Io>
void visit(Io& io, GrabcutOptions& options) {
  io.section(kGrabcut, [&](auto& inner) {
    inner.number("iterations", options.iterations, 1, 100);
    inner.number("downscale", options.downscale, 1, 16);
    inner.number("rim", options.rim, 0.0, 1.0);
  });
}

template <typename Io>
void visit(Io& io, DetectorOptions& options) {
  io.section("detector", [&](auto& inner) {
    inner.text("model", options.model);
    inner.number("input_px", options.input_px, 32, 4096);
    inner.number("min_score", options.min_score, 0.0, 1.0);
  });
}

SegmenterKind grabcut_kind() {
  return segmenter_kind<GrabcutSegmenter>(kGrabcut, {PromptKind::boxes});
}

SegmenterKind detector_kind() {
  SegmenterKind kind = segmenter_kind<DetectorSegmenter>("detector", {PromptKind::everything});
  kind.make = [](const SegmentationOptions& options, PromptKind) {
    return std::make_shared<DetectorSegmenter>(options.of<DetectorOptions>("detector"),
                                               options.of<GrabcutOptions>(kGrabcut));
  };
  return kind;
}

}  // namespace uniquadric
