#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "estimator/observation/silhouette.h"

namespace uniquadric {

/// What lies around a body's outline.
struct OutlineSurroundings {
  cv::Mat masks;  ///< CV_16UC1 ids
  cv::Mat depth;  ///< CV_32FC1 [m], 0 none; may be empty
  int id = 0;     ///< of the body
};

/// Whether the outline at a pixel (of the image as it is) is not the body's own edge, seen outwards along
/// `normal`: the image ends there, or what lies beside it is nearer.
bool is_cut(const OutlineSurroundings& around, const Eigen::Vector2d& pixel, const Eigen::Vector2d& normal,
            const SilhouetteOptions& options);

}  // namespace uniquadric
