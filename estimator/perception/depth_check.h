#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>

namespace uniquadric {

/// Which depth images are measurements. All numbers are ours.
struct DepthCheckOptions {
  bool enabled = true;
  static constexpr double max_change = 0.1;  // of a pixel's depth from image to image, for it to agree
  /// of the pixels that both images have: 0.95 and more agree at 30 Hz, by hand too; 0.15 to 0.6 at 1.5 Hz; a
  /// depth of another scale, or from another place, has next to none
  static constexpr double min_agreement = 0.3;
  /// [s] that images are compared over; what stays otherwise for longer is how it is: the camera has moved
  double max_gap_s = 0.25;
};

/// Depth images that go on from one another.
struct DepthRun {
  int images = 0;
  cv::Mat last;  // thinned out
  std::int64_t last_ns = 0;
};

/// Goes through the depth images of a sequence and says of each whether it is one: a sensor that fails gives
/// one value everywhere, or other depths than a moment before over the whole image. Of two runs of images
/// that contradict each other the longer one is believed: the first image may be the one that failed.
class DepthCheck {
 public:
  explicit DepthCheck(const DepthCheckOptions& options) : options_(options) {}

  /// Whether the next image (CV_32FC1 [m], 0 where there is none; stamps increase) is a measurement. One
  /// without any depth is: of nothing.
  bool is_measurement(std::int64_t stamp_ns, const cv::Mat& depth);

 private:
  bool outnumber(std::int64_t stamp_ns, const cv::Mat& thinned);

  DepthCheckOptions options_;
  DepthRun believed_, refused_;
};

}  // namespace uniquadric
