#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <opencv2/core/mat.hpp>

namespace uniquadric {

/// Exact depth at a subpixel; 0 beside an edge.
inline double exact_depth(const cv::Mat& depth, const Eigen::Vector2d& pixel) {
  const int u = int(std::floor(pixel.x())), v = int(std::floor(pixel.y()));
  if (u < 0 || v < 0 || u + 1 >= depth.cols || v + 1 >= depth.rows) return 0;
  const double a = pixel.x() - u, b = pixel.y() - v;
  const double z00 = depth.at<float>(v, u), z01 = depth.at<float>(v, u + 1);
  const double z10 = depth.at<float>(v + 1, u), z11 = depth.at<float>(v + 1, u + 1);
  const auto [low, high] = std::minmax({z00, z01, z10, z11});
  if (!(low > 0) || high > 1.03 * low) return 0;
  return 1 / ((1 - b) * ((1 - a) / z00 + a / z01) + b * ((1 - a) / z10 + a / z11));
}

}  // namespace uniquadric
