#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "core/geometry/camera.h"
#include "core/sequence/tracks.h"
#include "estimator/observation/perception.h"

namespace uniquadric {

/// A convex body by points of its surface with their outward normals, in its own frame.
struct SyntheticBody {
  Eigen::Matrix3Xd points, normals;
  Eigen::Vector3d semi_axes_m;
  std::function<Pose(double)> world_from_body;  ///< by time [s]
};

SyntheticBody box_body(const Eigen::Vector3d& semi_axes_m, std::function<Pose(double)> motion);
/// About z.
SyntheticBody cylinder_body(double radius_m, double half_height_m, std::function<Pose(double)> motion);
SyntheticBody ellipsoid_body(const Eigen::Vector3d& semi_axes_m, std::function<Pose(double)> motion);

struct SyntheticOptions {
  std::uint64_t seed = 1;
  int frames = 90;
  double rate_hz = 30;
  int features = 60;            ///< of a body, that are in view at once, about
  double pixel_sigma_px = 0.2;  ///< of features
  double depth_sigma_m = 0.003;
  double outline_sigma_px = 0.7;  ///< of each support line
  double point_sigma_m = 0.002;   ///< of the cloud, along the ray
  double normal_sigma = 0.1;      ///< of each component of its normals
  int directions = 16;
  std::function<Pose(double)> world_from_camera;
  /// Whether a body (index) is hidden at a time; its features have new track ids after it, unless found
  /// again.
  std::function<bool(int, double)> hidden;
  bool found_again = true;
};

struct SyntheticPerception {
  Camera camera;
  std::vector<PerceivedFrame> frames;
};

/// What perception would see of convex bodies, made from the truth without any image: features and clouds on
/// the faces turned to the camera, support lines of the projected points.
SyntheticPerception synthetic_perception(const std::vector<SyntheticBody>& bodies,
                                         const SyntheticOptions& options);

/// The truth of the same.
Tracks synthetic_truth(const std::vector<SyntheticBody>& bodies, const SyntheticOptions& options);

}  // namespace uniquadric
