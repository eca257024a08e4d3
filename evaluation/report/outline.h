#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/geometry/camera.h"
#include "core/geometry/pose.h"

namespace uniquadric {

/// The outline of the superellipsoid of dual exponent `exponent` (core/geometry/superquadric.h; below 1: of
/// the box) in the rectified image: the closed polygon [px] of the points where tangents of evenly spaced
/// directions touch it. Empty where the body is not wholly in front of the camera's principal plane.
std::vector<Eigen::Vector2d> superellipsoid_outline(const Camera& camera, const Pose& camera_from_object,
                                                    const Eigen::Vector3d& semi_axes_m, double exponent);

}  // namespace uniquadric
