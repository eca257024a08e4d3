#pragma once

#include <opencv2/core/mat.hpp>

#include "estimator/images/plane_depth.h"

namespace uniquadric {

/// For an autocorrelation exp(-d^2 / (2 l^2)) at d pixels, l = `correlation_px`; 0: white noise. Closed form:
/// with the plane's projector P and the noise's correlation C, residuals keep tr((I - P) C), and the mean's
/// variance is that of C.
WindowNoise window_noise(int half_px, double correlation_px);

/// The length l [px] of the noise in a depth image (CV_32FC1 [m], 0 none), from how much smaller residuals
/// are in narrow windows than in wide ones, in the median over a lattice of windows. 0 where too few of them
/// have a plane, or where it is longer than the windows tell: that is the form of things, not noise.
double noise_correlation_px(const cv::Mat& depth, const PlaneDepthOptions& options);

/// Both windows' factors at the length that an image's noise has.
SurfaceNoise surface_noise(const cv::Mat& depth, const PlaneDepthOptions& options);

}  // namespace uniquadric
