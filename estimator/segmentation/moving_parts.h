#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "core/geometry/camera.h"
#include "core/geometry/pose.h"
#include "estimator/features/frame_pair.h"

namespace uniquadric {

/// An earlier frame, and how the camera moved since then against the background.
struct EarlierImages : FrameImages {
  Pose before_from_now;
};

/// The parts (CV_16UC1 labels, 0 none) of a depth image that moved against the background. Had such a part
/// stood still, earlier images would show it; they show what lies behind, and other greys. More than a fifth
/// of its pixels has to be so contradicted in two earlier images. Pixels count that are in view, measured and
/// not hidden; half of the part's have to be. Depth contradicts by more than `ratio` times the median error
/// of the 300 other pixels nearest in depth, grey by more than twice theirs. All images have depth. `keeps`
/// (CV_16UC1 ids, 0 none; may be empty): parts that lie on it by half stay.
cv::Mat moving_parts(const cv::Mat& parts, const FrameImages& now, const std::vector<EarlierImages>& earlier,
                     const cv::Mat& keeps, const Camera& camera, double ratio);

}  // namespace uniquadric
