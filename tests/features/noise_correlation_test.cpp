#include "estimator/images/noise_correlation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "core/base/random.h"

namespace uniquadric {
namespace {

const cv::Size kSize(640, 480);

// Normal numbers with the autocorrelation exp(-d^2 / (2 l^2)).
cv::Mat correlated(double length_px, std::uint64_t seed) {
  RandomStream random(seed, "correlated");
  cv::Mat white(kSize, CV_32FC1), smooth;
  for (int v = 0; v < white.rows; ++v)
    for (int u = 0; u < white.cols; ++u) white.at<float>(v, u) = static_cast<float>(random.normal());
  if (length_px == 0) return white;
  cv::GaussianBlur(white, smooth, {}, length_px / std::numbers::sqrt2, 0, cv::BORDER_REFLECT);
  cv::Scalar mean, deviation;
  cv::meanStdDev(smooth, mean, deviation);
  return smooth / deviation[0];
}

// A sloping plane, inverse depth with noise.
cv::Mat noisy_plane(double length_px, std::uint64_t seed, double sigma = 0.003) {
  cv::Mat depth = correlated(length_px, seed);
  for (int v = 0; v < depth.rows; ++v)
    for (int u = 0; u < depth.cols; ++u)
      depth.at<float>(v, u) =
          static_cast<float>(1 / (0.6 + 2e-4 * (u - 320) - 1e-4 * (v - 240) + sigma * depth.at<float>(v, u)));
  return depth;
}

TEST(NoiseCorrelation, FindsTheLengthOfTheNoise) {
  for (const double length_px : {2.0, 3.0, 5.0})
    EXPECT_NEAR(noise_correlation_px(noisy_plane(length_px, 1), {}), length_px, 0.15 * length_px);
  EXPECT_LT(noise_correlation_px(noisy_plane(0, 1), {}), 0.6);
}

TEST(NoiseCorrelation, SaysNothingWithoutPlanes) {
  EXPECT_EQ(noise_correlation_px(cv::Mat::zeros(kSize, CV_32FC1), {}), 0);
  EXPECT_EQ(noise_correlation_px({}, {}), 0);
}

// A ball without noise: its form is the larger, the wider the window, beyond what any noise does.
TEST(NoiseCorrelation, DoesNotTakeFormForNoise) {
  cv::Mat depth(kSize, CV_32FC1);
  for (int v = 0; v < depth.rows; ++v)
    for (int u = 0; u < depth.cols; ++u)
      depth.at<float>(v, u) = static_cast<float>(
          2 - std::sqrt(1 - std::pow((u - 320) / 500.0, 2) - std::pow((v - 240) / 500.0, 2)));
  EXPECT_EQ(noise_correlation_px(depth, {}), 0);
}

TEST(NoiseCorrelation, NeedsAWiderWindow) {
  PlaneDepthOptions options;
  options.half_wide_px = options.half_window_px - 1;
  EXPECT_EQ(noise_correlation_px(noisy_plane(3, 1), options), 0);
}

TEST(NoiseCorrelation, IsNoneForWhiteNoise) {
  const WindowNoise noise = window_noise(3, 0);
  EXPECT_EQ(noise.middle, 1);
  EXPECT_EQ(noise.slope, 1);
  EXPECT_NEAR(window_noise(3, 0.05).middle, 1, 1e-9);
}

// The squared error over the variance that is told has mean 1 for noise of any length.
TEST(NoiseCorrelation, MakesTheSigmaOfAPlaneHonest) {
  PlaneDepthOptions options;
  options.min_sigma = 0;
  for (const double length_px : {0.0, 3.0, 5.0}) {
    double chi_square = 0, slope_chi_square = 0, ignorant = 0;
    int count = 0;
    for (std::uint64_t seed = 0; seed < 4; ++seed) {
      const cv::Mat depth = noisy_plane(length_px, seed);
      const SurfaceNoise noise = surface_noise(depth, options);
      for (int v = 20; v < kSize.height - 20; v += 20)
        for (int u = 20; u < kSize.width - 20; u += 20, ++count) {
          const double z = 1 / (0.6 + 2e-4 * (u - 320) - 1e-4 * (v - 240));
          const auto fit = fit_plane_depth(depth, {}, Eigen::Vector2d(u, v), options, noise);
          const auto white = fit_plane_depth(depth, {}, Eigen::Vector2d(u, v), options);
          ASSERT_TRUE(fit && white);
          chi_square += std::pow((fit->depth_m - z) / fit->sigma_m, 2);
          slope_chi_square += std::pow((fit->slope_per_px.x() - 2e-4) / fit->slope_sigma_per_px, 2);
          ignorant += std::pow((white->depth_m - z) / white->sigma_m, 2);
        }
    }
    EXPECT_NEAR(chi_square / count, 1, 0.35) << length_px;
    EXPECT_NEAR(slope_chi_square / count, 1, 0.35) << length_px;
    if (length_px > 0) EXPECT_GT(ignorant / count, 5) << length_px;
  }
}

}  // namespace
}  // namespace uniquadric
