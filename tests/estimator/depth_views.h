#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/base/random.h"
#include "core/geometry/pose.h"

namespace uniquadric {

/// A body about the origin of its frame, known by its tight box and by where rays meet it.
struct RayBody {
  std::string name;
  Eigen::Vector3d half_extents_m;
  /// Distance to the first hit along a ray in units of its direction's length; nothing for a miss.
  std::function<std::optional<double>(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction)> cast;
};

RayBody box_body(const std::string& name, const Eigen::Vector3d& half_extents_m);
RayBody ellipsoid_body(const std::string& name, const Eigen::Vector3d& semi_axes_m);
/// A deck of 0.8 x 0.2 m with four wheels below.
RayBody skateboard_body();

/// Camera `index` of `count` on an arc of 40 degrees around the body, 2.2 m away, 20 degrees above it.
Pose arc_camera(int index, int count);

struct DepthViewOptions {
  double noise_per_range = 0.005;
  double outliers = 0.02;       ///< share of the points, moved anywhere in a cube of 1 m
  double pose_noise_m = 0.003;  ///< of each view's camera, along each axis
};

/// Depth points (camera frame) of one view by a camera of 525 px focal length, every second pixel.
Eigen::Matrix3Xd depth_view(const RayBody& body, const Pose& body_from_camera,
                            const DepthViewOptions& options, RandomStream& random);

}  // namespace uniquadric
