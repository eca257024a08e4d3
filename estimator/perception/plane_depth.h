#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <optional>

namespace uniquadric {

/// How a feature's depth is read off a noisy depth image. All numbers are ours.
struct PlaneDepthOptions {
  int half_window_px = 3;  // 7x7: a seventh of the noise of one pixel, and a face's crease is seldom inside
  double max_jump = 0.04;  // relative to the window's median depth; a wall seen at 80 degrees stays below
  double min_share = 0.5;  // of the window's pixels that must lie on the plane
  double outlier_sigmas = 3;  // off the plane
  double min_sigma = 2e-4;    // of depth, relative: what no average takes away (calibration, creases)
};

/// A surface near a pixel: inverse depth is linear in the pixel on a plane, w(p) = w0 + slope . (p - pixel).
struct PlaneDepth {
  double depth_m = 0;
  double sigma_m = 0;                                      ///< standard deviation, from the fit's residuals
  Eigen::Vector2d slope_per_px = Eigen::Vector2d::Zero();  ///< of inverse depth [1/(m px)]
};

/// Depth at a pixel (raw, not undistorted) by a robust plane through the window's pixels that have the same
/// label as the pixel and lie near the surface that is nearest the window's centre. `depth` CV_32FC1 [m, 0
/// none]; `labels` CV_16UC1 or empty. Nothing where too few pixels lie on one plane.
std::optional<PlaneDepth> fit_plane_depth(const cv::Mat& depth, const cv::Mat& labels,
                                          const Eigen::Vector2d& pixel, const PlaneDepthOptions& options);

}  // namespace uniquadric
