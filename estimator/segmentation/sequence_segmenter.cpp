// The sequence's own masks, and none at all.
#include "estimator/segmentation/segmenter.h"

namespace uniquadric {
namespace {

struct NoOptions {};

template <typename Io>
void visit(Io& /*io*/, NoOptions& /*options*/) {}

class SequenceSegmenter final : public Segmenter {
 public:
  using Options = NoOptions;
  explicit SequenceSegmenter(const NoOptions& /*options*/) {}

  cv::Mat segment(const Sequence& sequence, const SegmenterInput& input, const FramePrompts& /*prompts*/,
                  std::uint64_t /*seed*/) const override {
    return input.frame.masks.empty() ? cv::Mat() : read_masks(sequence, input.frame);
  }
};

class NoSegmenter final : public Segmenter {
 public:
  using Options = NoOptions;
  explicit NoSegmenter(const NoOptions& /*options*/) {}

  cv::Mat segment(const Sequence& sequence, const SegmenterInput& /*input*/, const FramePrompts& /*prompts*/,
                  std::uint64_t /*seed*/) const override {
    return cv::Mat::zeros(sequence.camera.height, sequence.camera.width, CV_16UC1);
  }
};

}  // namespace

SegmenterKind sequence_kind() {  // prompts select among its bodies
  return segmenter_kind<SequenceSegmenter>(kSequenceMasks,
                                           {PromptKind::everything, PromptKind::boxes, PromptKind::points});
}

SegmenterKind no_masks_kind() {
  return segmenter_kind<NoSegmenter>(kNoMasks,
                                     {PromptKind::everything, PromptKind::boxes, PromptKind::points});
}

}  // namespace uniquadric
