#pragma once

#include <opencv2/core/mat.hpp>

#include "core/base/random.h"
#include "core/geometry/camera.h"
#include "estimator/segmentation/moved_pixels.h"

namespace uniquadric {

/// How bodies that touch are told apart by their motions. All numbers are ours.
struct MotionSplitOptions {
  int frames = 5;  // between the two images: a sixth of a second at 30 Hz, for slow bodies to move
  static constexpr double gate_px = 1.5;  // of a pixel's flow from a rigid motion, to belong to it
  static constexpr double min_share =
      0.2;            // of a part, that must move in another way for the part to be two bodies
  int samples = 400;  // pixels of a part that vote
  // of a part's median flow off the background's motion, in medians over the whole image: to move; 0:
  // whatever stands clear of planes is a body
  double moving_ratio = 6;
};

/// Splits parts (CV_16UC1 labels, 0 none) of `now` of which two shares moved as two rigid bodies since
/// `before`: the lesser share gets a new label. `camera` without distortion is exact; a lens is ignored,
/// which two motions of neighbouring pixels do not feel.
cv::Mat split_by_motion(const cv::Mat& parts, const RgbdImage& now, const EarlierImage& before,
                        const Camera& camera, const MotionSplitOptions& options, RandomStream& random);

}  // namespace uniquadric
