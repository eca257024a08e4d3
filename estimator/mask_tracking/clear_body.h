#pragma once

#include <map>
#include <opencv2/core/mat.hpp>

#include "core/geometry/camera.h"

namespace uniquadric {

/// The area that each id of masks (CV_16UC1, 0 none) covers at its depth (CV_32FC1 [m], 0 none), across the
/// line of sight [m^2]; pixels without depth count as the mean of the others, ids without any are left out.
std::map<int, double> mask_areas_m2(const cv::Mat& masks, const cv::Mat& depth, const Camera& camera);

/// A body that stands clear of all else is one piece of the depth image: pixels joined without a step of
/// depth of `jump` (relative) or more, that touches no other body's. Where most of a mask lies on one such
/// piece, whose area is at most `growth` times the body's, the piece becomes its mask, with what was its mask
/// and has no depth. Other masks, and those of bodies whose area is not known, stay.
cv::Mat fit_to_clear_bodies(const cv::Mat& masks, const cv::Mat& depth, const Camera& camera,
                            const std::map<int, double>& areas_m2, double jump, double growth);

}  // namespace uniquadric
