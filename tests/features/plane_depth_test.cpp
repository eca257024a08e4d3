#include "estimator/images/plane_depth.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/random.h"
#include "drawn_world.h"

namespace uniquadric {
namespace {

// Depth of the plane 1/z = 1/z0 + slope . (p - centre).
cv::Mat plane_image(double z0, const Eigen::Vector2d& slope, double noise, RandomStream& random) {
  cv::Mat depth(41, 41, CV_32FC1);
  for (int v = 0; v < depth.rows; ++v)
    for (int u = 0; u < depth.cols; ++u) {
      const double z = 1 / (1 / z0 + slope.dot(Eigen::Vector2d(u - 20, v - 20)));
      depth.at<float>(v, u) = static_cast<float>(z * (1 + noise * random.normal()));
    }
  return depth;
}

TEST(PlaneDepth, IsExactOnAPlaneWithoutNoiseAtAnySubpixel) {
  RandomStream random(1, "test");
  const Eigen::Vector2d slope(0.004, -0.002), pixel(20.4, 19.7);
  const auto fit = fit_plane_depth(plane_image(2.2, slope, 0, random), {}, pixel, {});
  ASSERT_TRUE(fit);
  constexpr double kSinglePrecision = 1e-6;  // of the image
  EXPECT_NEAR(fit->depth_m, 1 / (1 / 2.2 + slope.dot(pixel - Eigen::Vector2d(20, 20))), kSinglePrecision);
  EXPECT_LT((fit->slope_per_px - slope).norm(), kSinglePrecision);
}

// The squared error over the variance that is told has mean 1: neither boastful nor shy.
TEST(PlaneDepth, ItsSigmaIsHonest) {
  RandomStream random(2, "test");
  PlaneDepthOptions options;
  options.min_sigma = 0;
  double chi_square = 0, mean_sigma = 0;
  constexpr int kTrials = 2000;
  for (int i = 0; i < kTrials; ++i) {
    const double z = random.uniform(0.8, 4);
    const Eigen::Vector2d slope(random.uniform(-0.004, 0.004) / z, random.uniform(-0.004, 0.004) / z);
    const auto fit = fit_plane_depth(plane_image(z, slope, 0.005, random), {}, {20, 20}, options);
    ASSERT_TRUE(fit);
    chi_square += std::pow((fit->depth_m - z) / fit->sigma_m, 2) / kTrials;
    mean_sigma += fit->sigma_m / z / kTrials;
  }
  EXPECT_NEAR(mean_sigma, 0.005 / 15, 3e-5);  // 225 pixels; 49 for the 1 in 20 where the planes disagree
  EXPECT_NEAR(chi_square, 1, 0.15);           // of 2000 draws: sigma 0.03
}

// A crease of 90 degrees, seen symmetrically: every plane through it is too far. What is told must cover
// that.
TEST(PlaneDepth, ItsSigmaCoversACrease) {
  RandomStream random(6, "test");
  double chi_square = 0, worst = 0;
  constexpr int kTrials = 300;
  for (int i = 0; i < kTrials; ++i) {
    cv::Mat depth(41, 41, CV_32FC1);
    for (int v = 0; v < 41; ++v)
      for (int u = 0; u < 41; ++u)  // 2 m away, 525 px of focal length
        depth.at<float>(v, u) = float((2 + 2.0 / 525 * std::abs(u - 20)) * (1 + 0.005 * random.normal()));
    const auto fit = fit_plane_depth(depth, {}, {20, 20}, {});
    ASSERT_TRUE(fit);
    worst = std::max(worst, std::abs(fit->depth_m - 2));
    chi_square += std::pow((fit->depth_m - 2) / fit->sigma_m, 2) / kTrials;
  }
  EXPECT_LT(worst, 0.02);
  EXPECT_LT(chi_square, 4);
}

TEST(PlaneDepth, StaysOnItsSideOfAnEdge) {
  RandomStream random(3, "test");
  cv::Mat depth = plane_image(2, {0, 0}, 0.005, random);
  depth.colRange(22, 41).setTo(3);
  const auto fit = fit_plane_depth(depth, {}, {20, 20}, {});
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->depth_m, 2, 5 * fit->sigma_m);
}

TEST(PlaneDepth, StaysInItsMask) {
  RandomStream random(4, "test");
  cv::Mat depth = plane_image(2, {0, 0}, 0, random);
  depth.colRange(22, 41).setTo(2.03);  // too near for an edge
  cv::Mat labels = cv::Mat::zeros(depth.size(), CV_16UC1);
  labels.colRange(22, 41).setTo(5);
  const auto fit = fit_plane_depth(depth, labels, {20, 20}, {});
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->depth_m, 2, 1e-6);
  EXPECT_GT(std::abs(fit_plane_depth(depth, {}, {20, 20}, {})->depth_m - 2), 1e-3);
}

TEST(PlaneDepth, HasNothingToSayWithoutDepth) {
  EXPECT_FALSE(fit_plane_depth({}, {}, {20, 20}, {}));
  EXPECT_FALSE(fit_plane_depth(cv::Mat::zeros(41, 41, CV_32FC1), {}, {20, 20}, {}));
  const cv::Mat flat(41, 41, CV_32FC1, cv::Scalar(2));
  EXPECT_FALSE(fit_plane_depth(flat, {}, {-3, 20}, {}));
  EXPECT_FALSE(fit_plane_depth(flat, {}, {20, 41.2}, {}));
  EXPECT_FALSE(fit_plane_depth(flat, {}, {0, 0}, {}));  // a quarter of the window: under min_share
  cv::Mat holes = flat.clone();
  for (int v = 0; v < holes.rows; ++v)
    for (int u = 0; u < holes.cols; ++u)
      if ((u + v) % 5) holes.at<float>(v, u) = 0;
  EXPECT_FALSE(fit_plane_depth(holes, {}, {20, 20}, {}));
}

}  // namespace
}  // namespace uniquadric
