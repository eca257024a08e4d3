#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <optional>

#include "core/geometry/camera.h"

namespace uniquadric {

/// Point (camera frame, metres) that a pixel of a depth image (CV_32FC1, z in metres) shows; nothing where
/// nothing is measured.
inline std::optional<Eigen::Vector3d> depth_point(const cv::Mat& depth, const Camera& camera, int u, int v) {
  const double z = depth.at<float>(v, u);
  if (!(z > 0)) return std::nullopt;
  const auto ray = camera.unproject({u, v});
  if (!ray) return std::nullopt;
  return z * *ray;
}

}  // namespace uniquadric
