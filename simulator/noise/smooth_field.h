#pragma once

#include <opencv2/core/mat.hpp>

#include "core/base/random.h"

namespace uniquadric {

/// A Gaussian random field (32FC1) of unit variance and autocorrelation exp(-r^2 / (2 length_px^2)).
cv::Mat smooth_field(cv::Size size, double length_px, RandomStream stream);

}  // namespace uniquadric
