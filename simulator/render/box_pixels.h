#pragma once

#include <Eigen/Geometry>
#include <opencv2/core/types.hpp>

#include "core/geometry/camera.h"
#include "core/geometry/pose.h"

namespace uniquadric {

/// Pixels of the image that a box (object frame) can cover: those around its corners' projections, with a
/// margin of a pixel; all where some corner is nearer than `near_m`, none where all are, for an empty box and
/// for one beside the image.
cv::Rect pixels_of_box(const Eigen::AlignedBox3f& box, const Pose& camera_from_object, const Camera& camera,
                       double near_m);

}  // namespace uniquadric
