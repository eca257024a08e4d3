// The example of docs/add_segmenter.md, which quotes it.
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "estimator/segmentation/segmenter.h"

namespace uniquadric {
namespace {

struct RedOptions {
  double least_excess = 60;  // of red over green and blue [grey levels]; ours
};

template <typename Io>
void visit(Io& io, RedOptions& options) {
  io.section("red", [&](auto& inner) { inner.number("least_excess", options.least_excess, 1.0, 255.0); });
}

/// Connected red pixels are an object. Numbers the objects from 1.
class RedSegmenter final : public Segmenter {
 public:
  using Options = RedOptions;
  explicit RedSegmenter(const RedOptions& options) : options_(options) {}

  cv::Mat segment(const Sequence& /*sequence*/, const SegmenterInput& input, const FramePrompts& /*prompts*/,
                  std::uint64_t /*seed*/) const override {
    std::vector<cv::Mat> channels;  // blue, green, red
    cv::split(input.rgb, channels);
    cv::Mat excess, labels, ids;
    cv::subtract(channels[2], cv::max(channels[0], channels[1]), excess);
    cv::connectedComponents(excess >= options_.least_excess, labels);
    labels.convertTo(ids, CV_16U);
    return ids;
  }

 private:
  RedOptions options_;
};

SegmenterKind red_kind() {
  return segmenter_kind<RedSegmenter>("red", {PromptKind::everything});
}

TEST(RedSegmenter, FindsARedSquareOnGrey) {
  SegmenterInput input;
  input.rgb = cv::Mat(40, 60, CV_8UC3, cv::Scalar::all(120));
  input.rgb(cv::Rect(10, 5, 20, 15)).setTo(cv::Scalar(40, 40, 200));
  const cv::Mat masks = red_kind().make({}, PromptKind::everything)->segment({}, input, {}, 0);
  EXPECT_EQ(cv::countNonZero(masks), 20 * 15);
  EXPECT_EQ(masks.at<std::uint16_t>(5, 10), 1);
}

TEST(RedSegmenter, ReadsAndWritesItsOptions) {
  SegmenterKind kind = red_kind();
  OptionReader reader(ConfigNode::parse("red: {least_excess: 90}", "test.yaml"));
  kind.read(reader, kind.options);
  OptionWriter writer;
  kind.write(writer, kind.options);
  EXPECT_EQ(writer.yaml(), "red:\n  least_excess: 90\n");
}

}  // namespace
}  // namespace uniquadric
