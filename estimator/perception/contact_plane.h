#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <optional>

#include "core/base/random.h"
#include "core/geometry/camera.h"
#include "estimator/observation/perception.h"

namespace uniquadric {

/// How the surface that a body stands on is found. All numbers are ours.
struct ContactOptions {
  bool enabled = true;
  double ring = 0.3;                            // width about the mask, of the root of its area
  static constexpr double threshold = 0.01;     // of depth: what counts as one plane at first
  static constexpr double min_share = 0.3;      // of the ring's points that must lie on it
  static constexpr double max_below = 0.1;      // share of the body's points that may lie behind it
  static constexpr double lowest_share = 0.02;  // of the body's points: those that must reach down to it
};

/// The plane about a body's mask that the body reaches down to, in the camera's frame. `depth` CV_32FC1 [m, 0
/// none], `masks` CV_16UC1 ids. Nothing where the body is in the air, or what is about it is no plane.
std::optional<ContactPlane> contact_plane(const cv::Mat& depth, const cv::Mat& masks, int id,
                                          const Camera& camera, const ContactOptions& options,
                                          RandomStream& random);

}  // namespace uniquadric
