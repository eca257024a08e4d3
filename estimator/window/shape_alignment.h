#pragma once

#include <optional>

#include "estimator/factors/pose_prior.h"
#include "estimator/window/long_window.h"

namespace uniquadric {

/// How a body that shows too few of its points is found by its shape. All numbers are ours.
struct ShapeAlignmentOptions {
  double outline_sigma_px = 1.5;  // of a tangent: the shape is not known to the pixel
  double surface_sigma_m = 0.01;  // of a depth point
  int surface_points = 60;        // of the frame's cloud
  int min_evidence = 40;          // free tangents and depth points that there must be
  double max_outline_px = 4;      // mean distance of the tangents beyond which it is not found
  double max_surface_m = 0.02;    // the same of the depth points
  double turn_rad = 0.5;          // starts turned by so much about each axis, where the prediction is stale
};

/// Pose of a body of known shape from one outline and depth cloud (3 x n, camera frame) and a predicted
/// camera_from_object with its sigmas: the tangents touch it, the points lie on its surface. `stale`: tries
/// starts that are turned about the predicted one. Nothing where there is too little to see or it does not
/// fit.
std::optional<Pose> align_to_shape(const Camera& camera, const Silhouette& silhouette,
                                   const Eigen::Matrix3Xd& points, const Shape& shape, const Pose& predicted,
                                   const PoseSigmas& sigmas, bool stale,
                                   const ShapeAlignmentOptions& options);

}  // namespace uniquadric
