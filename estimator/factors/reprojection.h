#pragma once

#include <memory>

#include "core/geometry/camera.h"
#include "core/geometry/pose.h"
#include "estimator/observation/perception.h"

namespace ceres {
class CostFunction;
}

namespace uniquadric {

/// One sighting of a landmark of a body (Eq. 6). The paper transfers a point from frame to frame, which
/// leaves no room for the landmarks that Eq. 5 lists among the states; we take
///   r = [ (proj(camera_from_world * world_from_body * p_body) - pixel) / sigma_px ;
///         (z - depth) / depth_sigma ],
/// the third row only where the feature has a depth (depth_m > 0 and depth_sigma_m > 0).
/// Blocks: world_from_body (7), p_body (3) [m]. The camera is fixed and without distortion.
/// A point nearer than 0.1 m to the camera's principal plane, or behind it, is projected as if it were 0.1 m
/// in front: a finite and continuous residual, whose Jacobian still draws x and y to the ray.
std::unique_ptr<ceres::CostFunction> reprojection_factor(const Camera& camera, const Pose& world_from_camera,
                                                         const Feature& feature, double sigma_px);

}  // namespace uniquadric
