#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "core/base/random.h"
#include "core/geometry/camera.h"
#include "core/geometry/pose.h"

namespace uniquadric {

/// What of a frame its motion is found from.
struct FrameImages {
  cv::Mat gray;   ///< CV_8UC1
  cv::Mat depth;  ///< CV_32FC1 [m], 0 none; may be empty
};

/// A corner that two frames show.
struct PointPair {
  Eigen::Vector2d raw_a = Eigen::Vector2d::Zero(), raw_b = Eigen::Vector2d::Zero();  ///< on the images
  Eigen::Vector2d a = Eigen::Vector2d::Zero(), b = Eigen::Vector2d::Zero();          ///< undistorted
  double depth_a_m = 0, depth_b_m = 0;                                               ///< 0: not measured
  double sigma_a_m = 0, sigma_b_m = 0;
  bool is_inlier = false;  ///< it moves as most do
};

/// The frame's images from colour (CV_8UC3) and depth.
FrameImages frame_images(const cv::Mat& rgb, const cv::Mat& depth);

/// Corners all over an image, the strongest first: both `a` and `b` are this image.
std::vector<PointPair> corners_of(const Camera& camera, const FrameImages& image);

/// The points that optical flow finds again in `next`, an earlier or later image: there `b` is `next`.
std::vector<PointPair> followed(const Camera& camera, const FrameImages& b, const FrameImages& next,
                                const std::vector<PointPair>& points);

/// How the camera moved between two frames.
struct PairMotion {
  std::optional<Pose> b_from_a;  ///< by depth and pixels; nothing where too few points agree
  double share = 0;              ///< of the points with depth that agree
};

/// Fits the motion that the largest group of points with depth in both frames has (ten at least, and three
/// tenths), and marks its inliers.
PairMotion fit_motion(const Camera& camera, std::vector<PointPair>& points, RandomStream& random);

}  // namespace uniquadric
