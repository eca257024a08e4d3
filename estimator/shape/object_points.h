#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "core/geometry/camera.h"

namespace uniquadric {

/// How an object's points are taken from depth and mask. All numbers are ours: the paper gives none.
struct PointOptions {
  int smooth_px = 3;  // ours: half the window of the planes that take the noise off; 0: pixels as they are
  int erode_px = 1;   // each pixel shortens every axis: IoU 0.25, 0.30, 0.35 of a cube with 2, 1, 0 px
  double edge_ratio = 0.03;  // relative jump to a neighbour; a face seen at 80 degrees has 0.01
  double max_depth_m = 50;   // beyond every sensor here; 65.535 m is a common mark of invalid depth
  double voxel_m = 0.01;     // evens out the density of near and far, frontal and slanted faces
  static constexpr int outlier_neighbours = 12;
  static constexpr double outlier_sigmas = 2.5;
  int outlier_rounds = 1;  // two also drop the rim of slanted faces: IoU 0.30 of that cube, 0.40 with one
  int max_points = 2000;   // bounds the time of Alg. 1
  int min_points = 30;     // fewer say nothing about a shape
};

/// Points (3 x n, camera frame, metres) of the pixels under a mask (CV_8UC1, not 0) of a depth image
/// (CV_32FC1, z in metres, 0 where there is none): the mask is eroded, pixels at depth edges are left out,
/// the rest is averaged in voxels, their number is capped at even steps and statistical outliers are dropped.
/// Fewer than min_points come back as none.
Eigen::Matrix3Xd object_points(const cv::Mat& depth, const cv::Mat& mask, const Camera& camera,
                               const PointOptions& options);

/// Points of a surface with their normals.
struct SurfacePoints {
  Eigen::Matrix3Xd points;   ///< (3 x n) camera frame [m]
  Eigen::Matrix3Xd normals;  ///< (3 x n) unit, towards the camera; (3 x 0) where none were measured
};

/// object_points with the noise taken off: each point is its pixel on a robust plane through the depths of
/// its window (side 2 smooth_px + 1) under the mask; pixels without one, at edges and in strips of other
/// things, are left out. At most max_points pixels at even steps. Half the noise of a pixel's depth over the
/// window's half side is what stays.
SurfacePoints smoothed_points(const cv::Mat& depth, const cv::Mat& mask, const Camera& camera,
                              const PointOptions& options);

/// One point per occupied cube of side `voxel_m`: the mean of those inside, in the order of the cubes.
Eigen::Matrix3Xd voxel_means(const Eigen::Matrix3Xd& points, double voxel_m);

/// Without the points whose mean distance to their k nearest neighbours exceeds the cloud's mean of it by
/// `sigmas` standard deviations (Rusu et al., "Towards 3D point cloud based object maps", 2008).
Eigen::Matrix3Xd drop_outliers(const Eigen::Matrix3Xd& points, int neighbours, double sigmas);

}  // namespace uniquadric
