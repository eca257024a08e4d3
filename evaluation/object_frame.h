#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "core/geometry/ellipsoid.h"
#include "evaluation/iou/monte_carlo.h"
#include "evaluation/trajectory/pose_error.h"

namespace uniquadric {

/// Root of the summed variances that an estimate states of each part; empty where it states none. The mean of
/// |error|^2 over these squared is 1 where they are right, whichever way an error lies.
struct StatedSigmas {
  std::optional<double> translation_m, rotation_rad, semi_axes_m;
};

/// Root mean square, over the object's three axes, of the error along each over the sigma stated of it: its
/// square is the normalised error of a diagonal covariance over its dimension. Empty where a sigma is not
/// stated.
struct ErrorsInSigmas {
  std::optional<double> translation, rotation, semi_axes;
};

/// One object at one truth frame. Empty where there is no estimate, or no such figure of it.
struct ObjectFrame {
  std::int64_t frame = 0, stamp_ns = 0;
  Eigen::Vector3d true_semi_axes_m;
  std::optional<double> visible_fraction;  ///< of the true silhouette; empty where the truth does not say
  bool visible = true;                     ///< is_visible, or not known
  bool occluded = false;                   ///< is_occluded, or the estimate says so
  /// Largest angle between two directions from which the camera has seen the object so far, in its own frame;
  /// empty before it is visible.
  std::optional<double> arc_deg;
  std::optional<std::size_t> state;   ///< of the matched track, its index
  std::optional<Ellipsoid> estimate;  ///< axes renamed, body frame turned within the true shape's symmetry
  /// The box rotation that renamed the estimate's axes: |names| semi_axes_m has them as they came.
  Eigen::Matrix3d names = Eigen::Matrix3d::Identity();
  std::optional<PoseError> ape;                  ///< of `estimate`
  StatedSigmas stated;                           ///< of `estimate`: without one, of nothing
  ErrorsInSigmas in_sigmas;                      ///< of the same
  std::optional<double> ape_of_distance;         ///< APE.t over the true distance from the true camera
  std::optional<double> ape_rotation_naive_rad;  ///< of the estimate as it came
  std::optional<double> rotation_symmetric_rad;  ///< by the class of the true axes; empty for spheres
  /// From the truth frame before; empty where that has no estimate, and after a hole of the truth.
  std::optional<PoseError> rpe, motion;
  std::optional<double> iou3d, iou3d_box, d_shape_m;  ///< of the ellipsoids; of the boxes about them
  std::optional<double> iou3d_solid;                  ///< of the estimated body and the true one
  /// Of the same two surfaces: F1 of the shares near the other, mean of the mean distances.
  std::optional<double> surface_f1, chamfer_m;
  std::optional<MonteCarloIou> iou3d_monte_carlo;
  std::optional<double> iou2d, iou2d_ellipse;  ///< empty where one of the two has no elliptic outline
};

}  // namespace uniquadric
