#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/base/random.h"
#include "core/geometry/camera.h"
#include "core/geometry/pose.h"
#include "estimator/factors/pose_jacobian.h"

namespace uniquadric {

/// A point known in the body's frame and seen in one image.
struct LandmarkSighting {
  Eigen::Vector3d point_in_body;  ///< [m]
  double point_sigma_m = 0;       ///< of each coordinate
  Eigen::Vector2d pixel;          ///< undistorted
  double depth_m = 0;             ///< 0: not measured
  double depth_sigma_m = 0;
  bool rim = false;  ///< about the outline: it helps to find the pose, and vouches for none
};

struct PoseSolverOptions {
  double pixel_sigma_px = 0.4;  // ours: of KLT on the simulator's images
  double gate_sigmas = 3.5;     // ours: a sighting further off is no inlier; 1 in 2000 true ones is lost
  int iterations = 10;          // ours: Gauss-Newton from a prediction converges in four
  int min_inliers = 5;          // ours: three determine a pose, two more vouch for it
  static constexpr int ransac_iterations =
      200;  // ours: finds 30 % of inliers with three points in 99 of 100 cases
};

struct PoseSolution {
  Pose camera_from_body;
  /// Of a right-hand perturbation (translation, rotation vector) in the body's frame, by sightings that are
  /// not about the outline: those of a blank ball turn with the camera.
  Matrix6d information;
  std::vector<bool> inliers;  ///< of each sighting
  int inlier_count = 0;
};

/// Whitened residual (u, v, depth) of one sighting and its derivatives by the point and by a right-hand
/// perturbation (translation, rotation vector) of the pose.
struct LinearisedSighting {
  Eigen::Vector3d residual = Eigen::Vector3d::Zero();
  Eigen::Matrix3d by_point = Eigen::Matrix3d::Zero();
  Eigen::Matrix<double, 3, 6> by_pose = Eigen::Matrix<double, 3, 6>::Zero();
  bool valid = false;  ///< false: behind the camera
};
LinearisedSighting linearise(const Camera& camera, const LandmarkSighting& sighting,
                             const Pose& camera_from_body, double pixel_sigma_px);

/// Whether each part of the residual is within the gate.
bool is_inlier(const Camera& camera, const LandmarkSighting& sighting, const Pose& camera_from_body,
               const PoseSolverOptions& options);

/// Pose of a body from sightings of its points (Eq. 6, our reading, with the points held fixed): robust
/// Gauss-Newton from a prediction. Nothing with fewer than `min_inliers` inliers or when the points do not
/// determine a pose.
std::optional<PoseSolution> solve_pose(const Camera& camera, const std::vector<LandmarkSighting>& sightings,
                                       const Pose& predicted, const PoseSolverOptions& options);

/// The same without a prediction: three sightings with depth at a time give a candidate (Umeyama), the one
/// with the most inliers is refined.
std::optional<PoseSolution> find_pose(const Camera& camera, const std::vector<LandmarkSighting>& sightings,
                                      const PoseSolverOptions& options, RandomStream& random);

}  // namespace uniquadric
