#pragma once

#include <Eigen/Core>
#include <map>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "core/geometry/camera.h"

namespace uniquadric {

/// A point of a mask's outline: the middle of the edge between a pixel of the mask and one that is not.
struct OutlinePoint {
  Eigen::Vector2d image = Eigen::Vector2d::Zero();  ///< in the image as it is [px]
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< without the lens's distortion [px]
};

/// The part of an image that one id covers.
struct MaskRegion {
  cv::Rect box;
  cv::Mat mask;  ///< CV_8UC1 of the box's size, 255 on the body
  int area_px = 0;
};

/// The upright box of each id (CV_16UC1, 0 none).
std::map<int, cv::Rect> id_boxes(const cv::Mat& masks);

/// The region of each id (CV_16UC1, 0 none) whose parts have `min_pixels` together. Parts (8-neighbours)
/// smaller than `min_share` of the id's largest one are specks and left out.
std::map<int, MaskRegion> mask_regions(const cv::Mat& masks, int min_pixels, double min_share);

/// The region's outline, inner ones too, in the order of rows. Points that the lens model cannot undistort
/// are left out.
std::vector<OutlinePoint> outline_points(const MaskRegion& region, const Camera& camera);

/// Convex hull, counted from x to y (clockwise as the image is looked at), no three corners on a line. Fewer
/// than three corners where the points span no area.
std::vector<Eigen::Vector2d> convex_hull(std::vector<Eigen::Vector2d> points);

/// The direction [rad, in [0, pi/2)] of a side of the hull's rectangle of least area: one side lies on an
/// edge of the hull (Freeman and Shapira, 1975). 0 for hulls without area.
double least_rectangle_angle(const std::vector<Eigen::Vector2d>& hull);

/// Greatest normal . p over the points; `points` is not empty.
double support_offset(const std::vector<Eigen::Vector2d>& points, const Eigen::Vector2d& normal);

}  // namespace uniquadric
