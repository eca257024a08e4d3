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

/// Labels of an image, and which pixels have no other label near.
struct Regions {
  cv::Mat labels;              ///< CV_16UC1; never empty
  cv::Mat keep, start, patch;  ///< CV_8UC1, 255 where the squares of those half sides have one label
  int label(const Eigen::Vector2d& pixel) const;       ///< of the nearest pixel; -1 outside the image
  bool is_inside(const Eigen::Vector2d& pixel) const;  ///< by the smaller square; false outside the image
  bool is_well_inside(const Eigen::Vector2d& pixel) const;  ///< by the larger one
  bool contains_patch(const Eigen::Vector2d& pixel) const;  ///< what is looked at about it
};
/// `masks` CV_16UC1, or empty: all background. Half sides in pixels, at least 1: of where tracks may be,
/// where they may start, and of what is looked at about them.
Regions make_regions(const cv::Mat& masks, cv::Size size, int keep_px, int start_px, int patch_px);

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
