#pragma once

#include <opencv2/core/mat.hpp>

#include "core/geometry/camera.h"
#include "estimator/images/support_planes.h"

namespace uniquadric {

/// Normals (CV_64FC3 of the region's size, camera frame, of either sign) of what is seen in a region of a
/// depth image (CV_32FC1 [m], 0 none), between means of depth `reach_px` to either side of a pixel; 0 where
/// one of them is missing.
cv::Mat surface_normals(const cv::Mat& depth, const Camera& camera, const cv::Rect& region, int reach_px);

/// Whether a surface of that normal may be the plane's: they are within 45 degrees, half way to a wall that
/// stands on it, or the normal is 0.
bool faces_as(const Plane& plane, const cv::Vec3d& normal);

}  // namespace uniquadric
