#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/geometry/camera.h"
#include "core/geometry/pose.h"
#include "core/geometry/superquadric.h"

namespace uniquadric {

/// The outline of a superellipsoid in the rectified image: the closed polygon [px] of the points where
/// tangents of evenly spaced directions touch it. Empty where the body is not wholly in front of the camera's
/// principal plane.
std::vector<Eigen::Vector2d> superellipsoid_outline(const Camera& camera, const Pose& camera_from_object,
                                                    const Superellipsoid& body);

}  // namespace uniquadric
