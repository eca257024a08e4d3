#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "core/geometry/camera.h"

namespace uniquadric {

/// What tells a body from others when it comes back: its colours, and where depth shows it, size and place.
struct Appearance {
  std::vector<double> colours;  ///< histogram over hue and saturation, then grey levels; sums to 1
  double area_px = 0;
  std::optional<double> area_m2;           ///< of the silhouette at its median depth
  std::optional<Eigen::Vector3d> place_m;  ///< middle of the mask at its median depth, camera frame
};

/// Appearance of the pixels of a mask (CV_8UC1, of `region` of the images; not empty). `rgb` CV_8UC3 and
/// `depth` (CV_32FC1 [m], 0 none; may be empty) are whole images.
Appearance appearance_of(const cv::Mat& mask, const cv::Rect& region, const cv::Mat& rgb,
                         const cv::Mat& depth, const Camera& camera);

/// Bhattacharyya coefficient of two histograms: 1 for equal ones, 0 without a common colour.
double colour_similarity(const Appearance& a, const Appearance& b);

}  // namespace uniquadric
