#pragma once

#include <opencv2/core/mat.hpp>
#include <optional>

#include "core/geometry/camera.h"
#include "estimator/segmentation/motion_split.h"
#include "estimator/segmentation/moved_pixels.h"

namespace uniquadric {

/// The parts that moved against the background since `before`. The background's rigid motion is that of two
/// fifths of the image or more; nothing where there is none, as when flow fails at a fast turn. A part moved
/// when half of its pixels are off that motion by more than gate_px and by moving_ratio times what the
/// image's pixels are off in the median, and a tenth look unlike the place where they would have been, by
/// moving_ratio times what the image's do: on a plain wall flow errs, and nothing contradicts rest. Pixels
/// that were out of view do not count. `keeps` (CV_16UC1 ids, 0 none; may be empty): parts that lie on it by
/// half stay.
std::optional<cv::Mat> moving_parts(const cv::Mat& parts, const RgbdImage& now, const EarlierImage& before,
                                    const cv::Mat& keeps, const Camera& camera,
                                    const MotionSplitOptions& options);

}  // namespace uniquadric
