#pragma once

#include <opencv2/core/mat.hpp>

namespace uniquadric {

/// What colours say of pixels near an outline: log-likelihood of a body's colours over those beyond it, by
/// kernel densities (Parzen, "On estimation of a probability density function and mode", 1962) of both in a
/// window about each pixel, averaged over its 3 x 3 neighbours. 0 where `asked` is not set, or where either
/// has no samples nearby. The kernel is as wide as neighbouring pixels of the body differ.
/// `rgb`: CV_8UC3; `body`, `beyond`: CV_8UC1, the samples; `half`: of the window [px]. Returns CV_32FC1.
cv::Mat color_sides(const cv::Mat& rgb, const cv::Mat& body, const cv::Mat& beyond, const cv::Mat& asked,
                    int half);

}  // namespace uniquadric
