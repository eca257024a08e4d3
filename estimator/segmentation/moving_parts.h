#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "core/geometry/camera.h"
#include "core/geometry/pose.h"

namespace uniquadric {

/// An earlier depth image (CV_32FC1 [m], 0 none), and where what stands still was seen in it.
struct EarlierDepth {
  cv::Mat depth;
  Pose before_from_now;  ///< the background's motion
};

/// The parts (CV_16UC1 labels, 0 none) of a depth image (CV_32FC1 [m], 0 none) that moved against the
/// background. Had such a part stood still, earlier images would show it; they show what lies behind. A tenth
/// of its pixels in view has to be so contradicted in two earlier images, by more than ratio times
/// what depth is off at other pixels as far away (median). `keeps` (CV_16UC1 ids, 0 none; may be empty):
/// parts that lie on it by half stay.
cv::Mat moving_parts(const cv::Mat& parts, const cv::Mat& depth, const std::vector<EarlierDepth>& earlier,
                     const cv::Mat& keeps, const Camera& camera, double ratio);

}  // namespace uniquadric
