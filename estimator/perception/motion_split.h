#pragma once

#include <opencv2/core/mat.hpp>
#include <optional>

#include "core/base/random.h"
#include "core/geometry/camera.h"
#include "estimator/perception/dense_flow.h"

namespace uniquadric {

/// How bodies that touch are told apart by their motions. All numbers are ours.
struct MotionSplitOptions {
  int frames = 5;          // between the two images: a sixth of a second at 30 Hz, for slow bodies to move
  double gate_px = 1.5;    // of a pixel's flow from a rigid motion, to belong to it
  double min_share = 0.2;  // of a part, that must move in another way for the part to be two bodies
  int samples = 400;       // pixels of a part that vote
  // of a part's median flow off the background's motion, in medians over the whole image: to move; 0:
  // whatever stands clear of planes is a body
  double moving_ratio = 6;
};

/// An image and its depth (CV_32FC1 [m], 0 none).
struct RgbdImage {
  cv::Mat rgb, depth;
};

/// Splits parts (CV_16UC1 labels, 0 none) of `now` of which two shares moved as two rigid bodies since
/// `before`: the lesser share gets a new label. `camera` without distortion is exact; a lens is ignored,
/// which two motions of neighbouring pixels do not feel.
cv::Mat split_by_motion(const cv::Mat& parts, const RgbdImage& now, const RgbdImage& before,
                        const Camera& camera, const MotionSplitOptions& options, RandomStream& random);

/// The parts that moved against the background since `before`. The background's rigid motion is that of two
/// fifths of the image or more; nothing where there is none, as when flow fails at a fast turn. A part moved
/// when half of its pixels are off that motion by more than gate_px and by moving_ratio times what the
/// image's pixels are off in the median, and a tenth look unlike the place where they would have been, by
/// moving_ratio times what the image's do: on a plain wall flow errs, and nothing contradicts rest. Pixels
/// that were out of view do not count. `keeps` (CV_16UC1 ids, 0 none; may be empty): parts that lie on it by
/// half stay.
std::optional<cv::Mat> moving_parts(const cv::Mat& parts, const RgbdImage& now, const RgbdImage& before,
                                    const cv::Mat& keeps, const Camera& camera,
                                    const MotionSplitOptions& options);

}  // namespace uniquadric
