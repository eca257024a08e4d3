#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "core/geometry/camera.h"

namespace uniquadric {

/// A camera and the rays of its pixels, found once where its lens distorts: a depth sensor's disparities and
/// normals are those of the rays. From a camera it is made implicitly.
struct PixelRays {
  PixelRays() = default;
  PixelRays(const Camera& camera);  // NOLINT(google-explicit-constructor)

  /// (x, y) of a pixel's ray (x, y, 1); asserts that the distortion has an inverse there.
  Eigen::Vector2d at(int u, int v) const;

  Camera camera;
  cv::Mat rays;     ///< 64FC2: (x, y) of all pixels; empty without distortion
  cv::Mat columns;  ///< 64FC1: f_x x + c_x, the pixels' columns without distortion [px]; empty likewise
};

}  // namespace uniquadric
