#include "simulator/noise/depth_noise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "simulator/noise/stereo_depth.h"
#include "tests/simulator/noise_statistics.h"
#include "tests/simulator/same_image.h"

namespace uniquadric {
namespace {

std::vector<double> depth_errors(double z_m, const DepthNoise& noise, const Camera& camera = {}) {
  const cv::Mat depth_m(camera.height, camera.width, CV_32FC1, cv::Scalar(z_m));
  const cv::Mat noisy = add_depth_noise(depth_m, {}, camera, noise, 4, 17);
  std::vector<double> errors;
  for (auto p = noisy.begin<float>(); p != noisy.end<float>(); ++p) errors.push_back(*p - z_m);
  return errors;
}

TEST(DepthNoise, ProportionalSigmaIsKTimesZ) {
  DepthNoise noise;
  noise.k = 0.01;
  int cases = 0;
  for (const double z_m : {0.5, 2.0, 7.0}) {
    const auto errors = depth_errors(z_m, noise);
    const double count = static_cast<double>(errors.size());
    EXPECT_NEAR(mean(errors) / (0.01 * z_m), 0, kSigmas / std::sqrt(count)) << z_m;
    EXPECT_NEAR(deviation(errors) / (0.01 * z_m), 1, 1e-3 + kSigmas / std::sqrt(2 * count)) << z_m;
    ++cases;
  }
  EXPECT_EQ(cases, 3);
}

TEST(DepthNoise, StereoSigmaGrowsWithTheSquareOfZ) {
  Camera camera;
  camera.fx = 447;
  DepthNoise noise;
  noise.model = DepthNoise::Model::stereo;
  const double focal_baseline = 447 * noise.baseline_m;
  // variance of the rounding to disparity steps
  const double sigma_px = std::hypot(noise.disparity_sigma_px, noise.disparity_step_px / std::sqrt(12.0));
  for (const double z_m : {0.5, 1.0, 2.0, 4.0}) {
    const auto errors = depth_errors(z_m, noise, camera);
    const double relative_sigma = sigma_px * z_m / focal_baseline;  // second order in it is neglected
    EXPECT_NEAR(deviation(errors) / (sigma_px * z_m * z_m / focal_baseline), 1,
                0.01 + 5 * relative_sigma * relative_sigma)
        << z_m;
  }
}

TEST(DepthNoise, StereoMeasuresWholeDisparitySteps) {
  DepthNoise noise;
  noise.model = DepthNoise::Model::stereo;
  noise.edge_dropout = 0;
  const Camera camera;
  const cv::Mat depth_m(camera.height, camera.width, CV_32FC1, cv::Scalar(1.7));
  const cv::Mat noisy = add_depth_noise(depth_m, {}, camera, noise, 4, 17);
  for (int u = 0; u < noisy.cols; ++u) {
    const double steps = camera.fx * noise.baseline_m / noisy.at<float>(0, u) / noise.disparity_step_px;
    EXPECT_NEAR(steps, std::round(steps), 1e-3);  // 900 steps in single precision
  }
}

TEST(DepthNoise, LosesEdgesAtTheirRateAndWhatIsOutOfRange) {
  DepthNoise noise;
  noise.k = 0;
  noise.edge_dropout = 0.3;
  noise.min_range_m = 0.5;
  noise.max_range_m = 5;
  cv::Mat depth_m(1000, 60, CV_32FC1, cv::Scalar(2));
  depth_m.colRange(20, 30) = 3;    // edges: columns 19, 20, 29 and, to the far part, 30 ...
  depth_m.colRange(40, 50) = 0.4;  // too near; edges: 39, 40, 49, 50
  depth_m.colRange(55, 60) = 5.1;  // too far; edges: 54, 55
  const cv::Mat noisy = add_depth_noise(depth_m, {}, {}, noise, 4, 17);
  const auto lost = [&](int u) { return noisy.rows - cv::countNonZero(noisy.col(u)); };
  const double tolerance = kSigmas * std::sqrt(1000 * 0.3 * 0.7);
  for (const int u : {19, 20, 29, 30, 39, 50, 54}) EXPECT_NEAR(lost(u), 300, tolerance) << u;
  for (const int u : {0, 18, 21, 28, 31, 38, 51, 53}) EXPECT_EQ(lost(u), 0) << u;
  for (const int u : {40, 45, 49, 55, 59}) EXPECT_EQ(lost(u), 1000) << u;
  EXPECT_EQ(noisy.at<float>(0, 25), 3);
}

TEST(DepthNoise, NothingStaysNothingAndNoneIsExact) {
  DepthNoise noise;
  const cv::Mat nothing = cv::Mat::zeros(40, 40, CV_32FC1);
  EXPECT_EQ(cv::countNonZero(add_depth_noise(nothing, {}, {}, noise, 1, 1)), 0);
  noise.model = DepthNoise::Model::none;
  cv::Mat depth_m(40, 40, CV_32FC1, cv::Scalar(1.234f));
  depth_m.col(7) = 2.5;
  EXPECT_TRUE(same(add_depth_noise(depth_m, {}, {}, noise, 1, 1), depth_m));
}

TEST(DepthNoise, StereoSeesTwiceAndProportionalOnce) {
  DepthNoise noise;
  noise.k = 0, noise.disparity_sigma_px = 0, noise.disparity_step_px = 0, noise.edge_dropout = 0;
  noise.flying_pixels = 0;
  cv::Mat depth_m(4, 300, CV_32FC1, cv::Scalar(4));
  depth_m.colRange(100, 140) = 1;
  EXPECT_EQ(cv::countNonZero(add_depth_noise(depth_m, {}, {}, noise, 1, 1) == 0), 0);
  noise.model = DepthNoise::Model::stereo;
  const int width_px = static_cast<int>(Camera().fx * noise.baseline_m * 0.75);
  EXPECT_EQ(cv::countNonZero(add_depth_noise(depth_m, {}, {}, noise, 1, 1) == 0), 4 * width_px);
  noise.shadow = false;
  EXPECT_EQ(cv::countNonZero(add_depth_noise(depth_m, {}, {}, noise, 1, 1) == 0), 0);
}

TEST(StereoDepth, ANearEdgeThrowsAShadowOfTheStepInDisparityToItsLeft) {
  constexpr double kFocalBaseline = 50;  // px m
  cv::Mat depth_m(8, 300, CV_32FC1, cv::Scalar(4));
  depth_m.colRange(100, 140) = 1;
  depth_m.colRange(200, 210) = 0;  // nothing casts no shadow
  depth_m.colRange(250, 300) = 6;  // nor does what is farther
  const cv::Mat shadow = stereo_shadow(depth_m, kFocalBaseline);
  const int width_px = static_cast<int>(std::floor(kFocalBaseline * (1 / 1.0 - 1 / 4.0)));
  for (int u = 0; u < depth_m.cols; ++u)
    EXPECT_EQ(cv::countNonZero(shadow.col(u)), u >= 100 - width_px && u < 100 ? depth_m.rows : 0) << u;
}

TEST(StereoDepth, LosesPlanesByTheAngleBetweenRayAndNormal) {
  const Camera plain = {160, 120, 140, 150, 78.3, 60.9, {}};
  Camera bent = plain;
  bent.distortion = {-0.28, 0.07, 0.0012, -0.0008, 0.01};
  const double limit = std::cos(80 * std::numbers::pi / 180);
  constexpr double kUndecided = 2e-3;  // cosine: differences of inverse depth in single precision
  int lost = 0, kept = 0;
  for (const double tilt_deg : {0.0, 60.0, 79.0, 81.0, 86.0})
    for (const double azimuth_deg : {0.0, 50.0, 90.0, 200.0}) {
      const Camera& camera = azimuth_deg == 50.0 || azimuth_deg == 90.0 ? bent : plain;
      const double tilt = tilt_deg * std::numbers::pi / 180, azimuth = azimuth_deg * std::numbers::pi / 180;
      const Eigen::Vector3d normal(std::sin(tilt) * std::cos(azimuth), std::sin(tilt) * std::sin(azimuth),
                                   std::cos(tilt));
      cv::Mat depth_m = cv::Mat::zeros(camera.height, camera.width, CV_32FC1), cosine = depth_m.clone();
      for (int v = 0; v < camera.height; ++v)
        for (int u = 0; u < camera.width; ++u) {
          const Eigen::Vector3d ray = *camera.unproject({u, v});
          const double z_m = 2 * normal.z() / normal.dot(ray);  // the plane through (0, 0, 2)
          if (z_m > 0) depth_m.at<float>(v, u) = static_cast<float>(z_m);
          cosine.at<float>(v, u) = static_cast<float>(normal.dot(ray) / ray.norm());
        }
      const cv::Mat flat = flat_incidence(depth_m, camera, 80);
      for (int v = 1; v + 1 < camera.height; ++v)
        for (int u = 1; u + 1 < camera.width; ++u) {
          const double c = cosine.at<float>(v, u);
          if (depth_m.at<float>(v, u) <= 0 || std::abs(c - limit) < kUndecided) continue;
          ASSERT_EQ(flat.at<std::uint8_t>(v, u) != 0, c < limit)
              << tilt_deg << " " << azimuth_deg << " " << c;
          ++(c < limit ? lost : kept);
        }
    }
  EXPECT_GT(lost, 20000);
  EXPECT_GT(kept, 150000);
}

TEST(StereoDepth, FlyingPixelsLieEvenlyBetweenTheSidesOfTheEdge) {
  cv::Mat depth_m(2000, 40, CV_32FC1, cv::Scalar(1));
  depth_m.colRange(20, 40) = 3;
  const cv::Mat edges = depth_edges(depth_m);
  cv::Mat flying_m = depth_m.clone();
  scatter_edges(flying_m, edges, 0.3, 9, 4);
  std::vector<double> moved;
  for (int v = 0; v < depth_m.rows; ++v)
    for (int u = 0; u < depth_m.cols; ++u)
      if (flying_m.at<float>(v, u) != depth_m.at<float>(v, u)) {
        ASSERT_TRUE(u == 19 || u == 20) << u;
        moved.push_back(flying_m.at<float>(v, u));
      }
  EXPECT_NEAR(count_of(moved), 1200, kSigmas * std::sqrt(4000 * 0.3 * 0.7));
  EXPECT_NEAR(mean(moved), 2, kSigmas * 2 / std::sqrt(12 * count_of(moved)));  // even in [1, 3]
  EXPECT_NEAR(deviation(moved), 2 / std::sqrt(12.0), kSigmas * 0.5 / std::sqrt(count_of(moved)));
  EXPECT_GT(*std::min_element(moved.begin(), moved.end()), 1);
  EXPECT_LT(*std::max_element(moved.begin(), moved.end()), 3);
}

}  // namespace
}  // namespace uniquadric
