#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <optional>

namespace uniquadric {

/// How a feature's depth is read off a noisy depth image. All numbers are ours.
struct PlaneDepthOptions {
  int half_window_px = 3;  // 7x7: a seventh of the noise of one pixel
  int half_wide_px = 7;    // 15x15, where the surface is flat enough: a fifteenth
  double max_jump = 0.04;  // relative to the window's median depth; a wall seen at 80 degrees stays below
  static constexpr double min_share = 0.5;       // of the window's pixels that must lie on the plane
  static constexpr double outlier_sigmas = 3;    // off the plane
  static constexpr double agreement_sigmas = 2;  // of the wide and the narrow plane at the pixel
  static constexpr double curvature_share =
      0.6;  // of their difference that the narrow one is off by, where they disagree: in a
            // crease the bias grows with the window's side, 0.9; on a ball with its square, 0.3
  double min_sigma = 2e-4;  // of depth, relative: what no average takes away
  /// Noise that hangs together over pixels is averaged less than white noise: its length is measured in each
  /// image (noise_correlation_px). False: all noise counts as white.
  bool correlated_noise = true;
};

/// A surface near a pixel: inverse depth is linear in the pixel on a plane, w(p) = w0 + slope . (p - pixel).
struct PlaneDepth {
  double depth_m = 0;
  double sigma_m = 0;                                      ///< standard deviation
  Eigen::Vector2d slope_per_px = Eigen::Vector2d::Zero();  ///< of inverse depth [1/(m px)]
  double slope_sigma_per_px = 0;                           ///< of one component
};

/// What noise that hangs together over pixels does to a plane's fit in a square window, as factors of the
/// variances that white noise of the same residuals would have.
struct WindowNoise {
  double middle = 1;  ///< of the depth in the window's middle
  double slope = 1;   ///< of the plane's slope
  double residual =
      1;  ///< of the residuals, as a share of the noise: less, the more of it the plane takes up
};

struct SurfaceNoise {
  WindowNoise narrow, wide;
};

/// Depth at a pixel (raw, not undistorted) by robust planes through a narrow and a wide window's pixels that
/// have the same label as the pixel and lie near the surface at the window's middle. The wide one counts
/// where both agree; else the narrow one, whose sigma tells what curvature may do to it. `depth` CV_32FC1 [m,
/// 0 none]; `labels` CV_16UC1 or empty. Nothing where too few pixels lie on one plane.
std::optional<PlaneDepth> fit_plane_depth(const cv::Mat& depth, const cv::Mat& labels,
                                          const Eigen::Vector2d& pixel, const PlaneDepthOptions& options,
                                          const SurfaceNoise& noise = {});

/// Mean square of the residuals in the narrow window over that in the wide one, each about its own plane.
/// Nothing where one of them has none, or nothing is off it.
std::optional<double> residual_ratio(const cv::Mat& depth, const Eigen::Vector2d& pixel,
                                     const PlaneDepthOptions& options);

}  // namespace uniquadric
