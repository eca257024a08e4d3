#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace uniquadric {

/// A corner's place and how clear it is.
struct Corner {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< raw image
  double response = 0;                              ///< FAST's, grey levels
};

/// FAST corners (Rosten and Drummond, 2006) of a CV_8UC1 image, the clearest first; ties in order of the
/// rows.
std::vector<Corner> fast_corners(const cv::Mat& gray, int threshold);

/// Labels of an image and how far each pixel is from the next pixel of another label.
struct Regions {
  cv::Mat labels;                                     ///< CV_16UC1; never empty
  cv::Mat margin_px;                                  ///< CV_32FC1
  int label(const Eigen::Vector2d& pixel) const;      ///< of the nearest pixel; -1 outside the image
  double margin(const Eigen::Vector2d& pixel) const;  ///< of the nearest pixel; 0 outside the image
};
/// `masks` CV_16UC1, or empty: all background.
Regions make_regions(const cv::Mat& masks, cv::Size size);

/// Keeps points apart: what has been taken blocks a square around it.
class Spacing {
 public:
  explicit Spacing(cv::Size size);
  bool is_free(const Eigen::Vector2d& pixel) const;
  void take(const Eigen::Vector2d& pixel, double distance_px);

 private:
  cv::Mat taken_;
};

}  // namespace uniquadric
