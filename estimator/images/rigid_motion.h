#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/base/random.h"
#include "core/geometry/camera.h"
#include "core/geometry/pose.h"

namespace uniquadric {

/// A point known in a body's frame, and where a camera sees it.
struct PointSighting {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< body frame [m]
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< undistorted
  double depth_m = 0;                               ///< z in the camera; 0: not measured
  double depth_sigma_m = 0;                         ///< of the difference of measured and predicted depth
};

/// All numbers are ours.
struct RigidMotionOptions {
  double pixel_sigma = 0.12;  // of aligned corners [px], with what the points' own errors add
  double pixel_gate = 3;      // an inlier's distance [px]
  double depth_gate = 5;      // an inlier's distance in depth [sigma]
  static constexpr double depth_slack_m = 0.01;  // and what it may be off besides
  int iterations = 100;  // three points of half outliers are drawn clean with 1 - 1e-6
  int min_inliers = 6;
  double min_share = 0.4;  // of the sightings that must agree
};

struct RigidMotion {
  Pose camera_from_body;
  std::vector<bool> inlier;  ///< of each sighting
  int inliers = 0;
  /// Of a left perturbation (translation first, then rotation) in the camera frame.
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();
};

/// Residual of a sighting in its own sigmas: pixel x, y, depth (0 without). The Jacobian (may be null) is
/// with respect to a left perturbation xi = (rho, phi) of the pose: exp(xi) * camera_from_body. False when
/// the point lies behind the camera.
bool sighting_residual(const PointSighting& sighting, const Camera& camera, const Pose& camera_from_body,
                       double pixel_sigma, Eigen::Vector3d* residual, Eigen::Matrix<double, 3, 6>* jacobian);

/// The pose that most sightings agree on: RANSAC over three points with depth (and the prior, where given),
/// local optimisation of the best, robust least squares of its inliers over pixels and depths. `camera` is
/// without distortion. Nothing when fewer than min_inliers or min_share agree.
std::optional<RigidMotion> fit_rigid_motion(const std::vector<PointSighting>& sightings, const Camera& camera,
                                            const std::optional<Pose>& prior,
                                            const RigidMotionOptions& options, RandomStream& random);

}  // namespace uniquadric
