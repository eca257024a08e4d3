#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "core/geometry/camera.h"
#include "estimator/shape/object_points.h"

namespace uniquadric {

/// A point as an image shows it.
struct ImagePoint {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< raw
  double inverse_depth = 0;                         ///< [1/m]
};

/// The surface around a point: inverse depth is linear in the pixel, w(p) = w0 + slope . (p - pixel).
struct PointPlane {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  double inverse_depth = 0;
  Eigen::Vector2d slope_per_px = Eigen::Vector2d::Zero();
};

/// All numbers are ours.
struct PointPlaneOptions {
  double reach_px = 14;                     // of a point: beyond, nothing is known of the depth
  static constexpr int neighbours = 12;     // that a plane is laid through
  static constexpr int min_neighbours = 5;  // of them on it
  double max_jump = 0.03;                   // relative depth to a neighbour on the same surface
  bool one_body = false;                    // whether slivers of other things are among the points
  double row_gap_px = 0;  // between the rows of a spinning sensor, along v; 0: there are none
};

/// The paper's depth of a feature from LiDAR (spherical projection, k nearest, a plane that the line of sight
/// cuts), at every point of one body: planes by least squares through its nearest neighbours in the image,
/// those across a jump in depth left out. Points with too few neighbours on their surface are left out
/// themselves. Where rows are further apart than points in them, what is near is reckoned with the rows drawn
/// together: the nearest points of all would be one row's, and tell no plane.
std::vector<PointPlane> point_planes(const std::vector<ImagePoint>& points, const PointPlaneOptions& options);

/// Depth [m] of the pixels with a label (masks CV_16UC1; empty: all are 0) along their lines of sight: on the
/// plane of the nearest point within `reach_px`. `depth` CV_32FC1, others untouched.
void fill_depth(const std::vector<PointPlane>& planes, int label, const cv::Mat& masks, double reach_px,
                cv::Mat& depth);

/// The points on their planes, with normals; at most `most` at even steps.
SurfacePoints surface_points(const std::vector<PointPlane>& planes, const Camera& camera, int most);

}  // namespace uniquadric
