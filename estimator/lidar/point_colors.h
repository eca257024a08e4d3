#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "core/geometry/camera.h"

namespace uniquadric {

/// Colours of points (3 x n, camera frame [m], in front of it) in an image (CV_8UC3), each the mean of a few
/// pixels about it: CIE L*a*b* (3 x n), L from 0 to 100. What lies outside has the colour of the border.
Eigen::Matrix3Xf point_colors(const cv::Mat& rgb, const Camera& lens, const Eigen::Matrix3Xd& points);

}  // namespace uniquadric
