// A SAM-style network as a segmenter: everything, points or boxes.
#include <map>
#include <utility>

#include "estimator/segmentation/sam_segmenter.h"
#include "estimator/segmentation/segmenter.h"

namespace uniquadric {
namespace {

class PromptedSam final : public Segmenter {
 public:
  using Options = SamOptions;
  explicit PromptedSam(const SamOptions& options) : sam_(options) {}

  cv::Mat segment(const Sequence& /*sequence*/, const SegmenterInput& input, const FramePrompts& prompts,
                  std::uint64_t /*seed*/) const override {
    if (prompts.kind == PromptKind::everything) return sam_.segment_everything(input.rgb);
    std::vector<SamPrompt> asked;
    for (const auto& box : prompts.boxes) asked.push_back({box.id, {}, {box}});
    std::map<int, SamPrompt> by_id;
    for (const auto& point : prompts.points) by_id[point.id].points.push_back(point);
    for (auto& [id, prompt] : by_id) {
      prompt.id = id;
      asked.push_back(std::move(prompt));
    }
    return sam_.segment(input.rgb, asked);
  }

 private:
  SamSegmenter sam_;
};

}  // namespace

template <typename Io>
void visit(Io& io, SamOptions& options) {
  io.section("sam", [&](auto& inner) {
    inner.text("encoder", options.encoder);
    inner.text("decoder", options.decoder);
    inner.number("input_px", options.input_px, 16, 4096);
    inner.number("decoder_points", options.decoder_points, 0, 1000);
    inner.number("grid", options.grid, 1, 64);
    inner.number("min_quality", options.min_quality, 0.0, 1.0);
    inner.number("max_share", options.max_share, 0.0, 1.0);
  });
}

SegmenterKind sam_kind() {
  return segmenter_kind<PromptedSam>("sam", {PromptKind::everything, PromptKind::boxes, PromptKind::points});
}

}  // namespace uniquadric
