#pragma once

#include <opencv2/core/mat.hpp>

#include "simulator/noise/pixel_rays.h"
#include "simulator/scene/scene.h"

namespace uniquadric {

// Errors of where depth stands in the image. Depth: 32FC1, z along the optical axis [m], 0 = nothing.

/// Pixels within smear_px of an edge (8UC1) take the mean disparity of a window of that half width: so a
/// matching window that both sides of an edge fill sees a surface between them.
void smear_disparity(cv::Mat& depth_m, const cv::Mat& edges, double smear_px);

/// The depth of a camera that stands color_offset_m to the right of the colour camera, parallel to it.
/// `registered`: `depth_m`, without what hides from the depth camera behind something nearer in `true_m`.
/// Else each pixel moves to where a depth camera with the same lens sees its point: without distortion by
/// f_x color_offset_m / z to the left. The nearer one stays. Last, the image moves by registration_error_px;
/// what comes in from outside is nothing.
cv::Mat seen_from_depth_camera(const cv::Mat& depth_m, const cv::Mat& true_m, const PixelRays& rays,
                               const DepthNoise& noise);

}  // namespace uniquadric
