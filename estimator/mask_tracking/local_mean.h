#pragma once

#include <opencv2/core/mat.hpp>

namespace uniquadric {

/// Mean of `values` (CV_32FC1) over the chosen pixels (CV_8UC1) of a window around each pixel; 0 where it
/// holds none. `window`: its side [px], odd.
cv::Mat local_mean(const cv::Mat& values, const cv::Mat& chosen, int window);

}  // namespace uniquadric
