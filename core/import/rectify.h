#pragma once

#include <opencv2/core/mat.hpp>

#include "core/geometry/camera.h"

namespace uniquadric {

/// The image's undistorted pixels: the one a pinhole camera of the same width, height, fx, fy, cx, cy would
/// take; outside of the original black (0). `interpolate`: linearly between pixels, else the nearest pixel's
/// value, as depth and ids want it. Returns the image itself when the camera has no distortion.
cv::Mat rectify(const Camera& camera, const cv::Mat& image, bool interpolate);

}  // namespace uniquadric
