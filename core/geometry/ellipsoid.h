#pragma once

#include <Eigen/Core>

#include "core/geometry/camera.h"
#include "core/geometry/pose.h"

namespace uniquadric {

/// An ellipsoid as centre, orientation and semi-axes: the paper's 9-DoF quadric.
struct Ellipsoid {
  Pose world_from_object;
  Eigen::Vector3d semi_axes_m = Eigen::Vector3d::Ones();
};

/// An ellipse in the image, which is also its rotated rectangle RotBbox {x_c, y_c, a, b, theta} with half
/// sides a >= b. `angle_rad` in [0, pi) runs from the image x axis to the major axis, towards y (down).
struct Ellipse {
  Eigen::Vector2d center;                 ///< [px]
  double semi_major = 0, semi_minor = 0;  ///< [px]
  double angle_rad = 0;
};

enum class ProjectionStatus {
  ok,
  behind,          ///< wholly behind the camera's principal plane
  not_an_ellipse,  ///< crosses the principal plane: the image is a parabola or a hyperbola; or it is so
                   ///< thin (1:1e-15) that it cannot be told from a line
  inside,          ///< the camera centre lies inside the ellipsoid (or on it): there is no outline
};
const char* to_string(ProjectionStatus status);

struct EllipseProjection {
  ProjectionStatus status = ProjectionStatus::behind;
  Ellipse ellipse;  ///< of meaning only when status is ok
};

/// Q*_o = diag(a_x^2, a_y^2, a_z^2, -1) (Eq. 10).
Eigen::Matrix4d object_dual_quadric(const Eigen::Vector3d& semi_axes_m);

/// Q* in the frame `frame_from_object` maps to (Eq. 8).
Eigen::Matrix4d dual_quadric(const Pose& frame_from_object, const Eigen::Vector3d& semi_axes_m);

/// Outline of an ellipsoid in a view: C* = P Q*_o P^T with P = K [R|t] of camera_from_object (Eq. 11),
/// normalised to C*_33 = -1. Lens distortion is not applied: an ellipse is the outline in the rectified
/// image.
EllipseProjection project(const Camera& camera, const Pose& camera_from_object,
                          const Eigen::Vector3d& semi_axes_m);

/// Dual conic of a RotBbox (Eq. 13), C*_33 = -1.
Eigen::Matrix3d dual_conic(const Ellipse& ellipse);

/// Ellipse of a dual conic: mu = -C*_{1:2,3}, Sigma = C*_{1:2,1:2} + mu mu^T after normalisation to C*_33 =
/// -1. Asserts that Sigma is positive definite.
Ellipse ellipse_from_dual_conic(const Eigen::Matrix3d& dual_conic);

/// Sigma of an ellipse: R(theta) diag(a^2, b^2) R(theta)^T [px^2].
Eigen::Matrix2d ellipse_covariance(const Ellipse& ellipse);

}  // namespace uniquadric
