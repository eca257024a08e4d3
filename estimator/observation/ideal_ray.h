#pragma once

#include <Eigen/Core>

#include "core/geometry/camera.h"

namespace uniquadric {

/// Ray (x, y, 1) through a pixel without distortion, which the camera's own lens is not asked about.
inline Eigen::Vector3d ideal_ray(const Camera& camera, const Eigen::Vector2d& undistorted) {
  return {(undistorted.x() - camera.cx) / camera.fx, (undistorted.y() - camera.cy) / camera.fy, 1};
}

/// Pixel without distortion of a ray (x, y, 1).
inline Eigen::Vector2d ideal_pixel(const Camera& camera, const Eigen::Vector3d& ray) {
  return {camera.fx * ray.x() + camera.cx, camera.fy * ray.y() + camera.cy};
}

}  // namespace uniquadric
