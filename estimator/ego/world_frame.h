#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "core/base/random.h"
#include "core/geometry/camera.h"
#include "core/geometry/pose.h"

namespace uniquadric {

/// All numbers are ours.
struct UprightOptions {
  double plane_threshold_m = 0.04;  // twice the noise of a depth sensor at 4 m
  double min_share = 0.04;          // of the points, on the floor
  double max_tilt_deg = 50;         // of the camera, held by a person
  double max_range_m = 8;
  static constexpr int step_px = 8;  // between the pixels that are looked at
};

/// The normal of the largest plane of points that is level for a sensor held roughly as `upright` says (the
/// world's up in its frame, unit length): floor, road, table, ceiling. Unit length, pointing up; nothing when
/// there is none. Of the options thresholds, share and tilt count.
std::optional<Eigen::Vector3d> find_up(std::vector<Eigen::Vector3d> points, const Eigen::Vector3d& upright,
                                       const UprightOptions& options, RandomStream& random);
/// The world's up in a camera's frame, by the points of its depth image. `depth`
/// CV_32FC1 [m, 0 none]; `masks` CV_16UC1 or empty: labels other than 0 are left out.
std::optional<Eigen::Vector3d> find_up(const cv::Mat& depth, const cv::Mat& masks, const Camera& camera,
                                       const UprightOptions& options, RandomStream& random);

/// The pose of a camera at the world's origin, z up, x towards the camera's right.
Pose upright_world_from_camera(const Eigen::Vector3d& up_in_camera);

}  // namespace uniquadric
