#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "simulator/noise/depth_noise.h"
#include "simulator/noise/image_noise.h"
#include "simulator/noise/normals.h"
#include "simulator/noise/outline_distance.h"
#include "simulator/noise/segmenter.h"
#include "simulator/noise/stereo_depth.h"

namespace uniquadric {
namespace {

constexpr double kSigmas = 5;  // a sound sampler fails a test of its moments once in two million runs

double count_of(const std::vector<double>& x) {
  return static_cast<double>(x.size());
}

double mean(const std::vector<double>& x) {
  return std::accumulate(x.begin(), x.end(), 0.0) / count_of(x);
}

double deviation(const std::vector<double>& x) {
  const double m = mean(x);
  return std::sqrt(std::accumulate(x.begin(), x.end(), 0.0,
                                   [m](double sum, double v) { return sum + (v - m) * (v - m); }) /
                   count_of(x));
}

// sum (n - expected)^2 / expected must stay below its mean + kSigmas standard deviations
void expect_chi_square(const std::vector<double>& counts, const std::vector<double>& expected) {
  double chi_square = 0;
  for (std::size_t i = 0; i < counts.size(); ++i)
    chi_square += (counts[i] - expected[i]) * (counts[i] - expected[i]) / expected[i];
  const double freedom = static_cast<double>(counts.size() - 1);
  EXPECT_LT(chi_square, freedom + kSigmas * std::sqrt(2 * freedom));
  EXPECT_GT(chi_square, freedom - kSigmas * std::sqrt(2 * freedom));  // too even is not random either
}

bool same(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_INF) == 0;
}

TEST(Normals, QuantileInvertsTheDistribution) {
  for (const double p : {1e-9, 0.001, 0.3, 0.5, 0.9, 0.99999})
    EXPECT_NEAR(normal_cdf(normal_quantile(p)) / p, 1, 1e-12);    // some roundings of erfc
  EXPECT_NEAR(normal_quantile(0.975), 1.959963984540054, 1e-12);  // tables
}

TEST(Normals, FollowTheNormalDistributionInBulkAndTail) {
  constexpr int kCount = 4'000'000;
  std::vector<float> values(kCount);
  RandomStream stream(3, "test");
  fill_normals(stream, values);
  const std::vector<double> x(values.begin(), values.end());
  EXPECT_NEAR(mean(x), 0, kSigmas / std::sqrt(kCount));
  EXPECT_NEAR(deviation(x), 1, 1e-4 + kSigmas / std::sqrt(2.0 * kCount));
  constexpr double kFirst = -4.5, kStep = 0.125;  // 45 draws beyond 4.5 are expected
  constexpr int kBins = 74;
  std::vector<double> counts(kBins), expected(kBins);
  for (const double v : x)
    ++counts[std::clamp(static_cast<int>(std::floor((v - kFirst) / kStep)) + 1, 0, kBins - 1)];
  for (int i = 0; i < kBins; ++i) {
    const double low = kFirst + (i - 1) * kStep;
    expected[i] = kCount * ((i == kBins - 1 ? 1 : normal_cdf(low + kStep)) - (i == 0 ? 0 : normal_cdf(low)));
  }
  expect_chi_square(counts, expected);
}

cv::Mat add_image_noise(const cv::Mat& image, const ImageNoise& noise, std::uint64_t seed,
                        std::int64_t frame) {
  cv::Mat noisy = image.clone();
  ImageNoiseSource source(noise, seed);
  for (int v = 0; v < noisy.rows; ++v)
    source.add_to_row(frame, v, {noisy.ptr(v), noisy.elemSize() * static_cast<std::size_t>(noisy.cols)});
  return noisy;
}

TEST(ImageNoise, IsRoundedGaussianNoise) {
  const ImageNoise noise{2.3};
  const cv::Mat grey(480, 641, CV_8UC3, cv::Scalar::all(128));
  const cv::Mat noisy = add_image_noise(grey, noise, 1, 5);
  const auto count = static_cast<double>(noisy.total() * 3);
  constexpr int kReach = 8;  // pooled beyond: 3.7 sigma, some 200 draws
  std::vector<double> counts(2 * kReach + 1), expected(2 * kReach + 1);
  for (auto p = noisy.datastart; p != noisy.dataend; ++p)
    ++counts[std::clamp(*p - 128, -kReach, kReach) + kReach];
  for (int i = -kReach; i <= kReach; ++i)
    expected[i + kReach] = count * ((i == kReach ? 1 : normal_cdf((i + 0.5) / noise.sigma)) -
                                    (i == -kReach ? 0 : normal_cdf((i - 0.5) / noise.sigma)));
  expect_chi_square(counts, expected);
}

TEST(ImageNoise, StopsAtBlackAndWhiteAndDependsOnSeedAndFrame) {
  cv::Mat image(64, 64, CV_8UC3, cv::Scalar(0, 255, 100));
  const cv::Mat noisy = add_image_noise(image, {40}, 1, 5);
  double darkest = 0, brightest = 0;
  cv::minMaxIdx(noisy.reshape(1), &darkest, &brightest);
  EXPECT_EQ(darkest, 0);
  EXPECT_EQ(brightest, 255);
  EXPECT_EQ(noisy.at<cv::Vec3b>(0, 0)[0] < 200 && noisy.at<cv::Vec3b>(0, 0)[1] > 55, true);  // no wrap around
  EXPECT_TRUE(same(noisy, add_image_noise(image, {40}, 1, 5)));
  EXPECT_FALSE(same(noisy, add_image_noise(image, {40}, 2, 5)));
  EXPECT_FALSE(same(noisy, add_image_noise(image, {40}, 1, 6)));
  EXPECT_TRUE(same(image, add_image_noise(image, {0}, 1, 5)));
}

TEST(ImageNoise, ShotNoiseAddsAVarianceInProportionToTheSignal) {
  const ImageNoise noise{1.5, 8};
  int cases = 0;
  for (const int value : {0, 40, 120, 200}) {
    const cv::Mat grey(480, 640, CV_8UC3, cv::Scalar::all(value));
    const cv::Mat noisy = add_image_noise(grey, noise, 1, 5);
    const std::vector<double> x(noisy.datastart, noisy.dataend);
    const double variance = 1.5 * 1.5 + value / 8.0 + 1 / 12.0;  // Sheppard: rounding adds 1/12
    if (value == 0) {                                            // the half below black is cut off
      EXPECT_NEAR(mean(x), 1.5 / std::sqrt(2 * std::numbers::pi), 0.02);
    } else {
      EXPECT_NEAR(mean(x), value, kSigmas * std::sqrt(variance / count_of(x)));
      EXPECT_NEAR(deviation(x) / std::sqrt(variance), 1, 2e-4 + kSigmas / std::sqrt(2 * count_of(x)))
          << value;
    }
    ++cases;
  }
  EXPECT_EQ(cases, 4);
}

TEST(ImageNoise, IsWhite) {
  const cv::Mat grey(256, 256, CV_8UC3, cv::Scalar::all(128));
  const cv::Mat noisy = add_image_noise(grey, {3}, 1, 5).reshape(1);
  const double count = static_cast<double>(noisy.total());
  const auto correlation = [&](int dx, int dy) {
    double sum = 0;
    for (int v = 0; v + dy < noisy.rows; ++v)
      for (int u = 0; u + dx < noisy.cols; ++u)
        sum += (noisy.at<std::uint8_t>(v, u) - 128.0) * (noisy.at<std::uint8_t>(v + dy, u + dx) - 128.0);
    return sum / count / (9 + 1 / 12.0);  // Sheppard: rounding adds 1/12
  };
  for (const auto& [dx, dy] : {std::pair{1, 0}, {2, 0}, {3, 0}, {0, 1}, {0, 2}})
    EXPECT_NEAR(correlation(dx, dy), 0, kSigmas / std::sqrt(count)) << dx << ", " << dy;
}

std::vector<double> depth_errors(double z_m, const DepthNoise& noise, const Camera& camera = {}) {
  const cv::Mat depth_m(camera.height, camera.width, CV_32FC1, cv::Scalar(z_m));
  const cv::Mat noisy = add_depth_noise(depth_m, camera, noise, 4, 17);
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
  const cv::Mat noisy = add_depth_noise(depth_m, camera, noise, 4, 17);
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
  const cv::Mat noisy = add_depth_noise(depth_m, {}, noise, 4, 17);
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
  EXPECT_EQ(cv::countNonZero(add_depth_noise(nothing, {}, noise, 1, 1)), 0);
  noise.model = DepthNoise::Model::none;
  cv::Mat depth_m(40, 40, CV_32FC1, cv::Scalar(1.234f));
  depth_m.col(7) = 2.5;
  EXPECT_TRUE(same(add_depth_noise(depth_m, {}, noise, 1, 1), depth_m));
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
  const Camera camera = {160, 120, 140, 150, 78.3, 60.9, {}};
  const double limit = std::cos(80 * std::numbers::pi / 180);
  constexpr double kUndecided = 2e-3;  // cosine: differences of inverse depth in single precision
  int lost = 0, kept = 0;
  for (const double tilt_deg : {0.0, 60.0, 79.0, 81.0, 86.0})
    for (const double azimuth_deg : {0.0, 50.0, 90.0, 200.0}) {
      const double tilt = tilt_deg * std::numbers::pi / 180, azimuth = azimuth_deg * std::numbers::pi / 180;
      const Eigen::Vector3d normal(std::sin(tilt) * std::cos(azimuth), std::sin(tilt) * std::sin(azimuth),
                                   std::cos(tilt));
      cv::Mat depth_m = cv::Mat::zeros(camera.height, camera.width, CV_32FC1), cosine = depth_m.clone();
      for (int v = 0; v < camera.height; ++v)
        for (int u = 0; u < camera.width; ++u) {
          const Eigen::Vector3d ray((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1);
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

TEST(DepthNoise, StereoSeesTwiceAndProportionalOnce) {
  DepthNoise noise;
  noise.k = 0, noise.disparity_sigma_px = 0, noise.disparity_step_px = 0, noise.edge_dropout = 0;
  noise.flying_pixels = 0;
  cv::Mat depth_m(4, 300, CV_32FC1, cv::Scalar(4));
  depth_m.colRange(100, 140) = 1;
  EXPECT_EQ(cv::countNonZero(add_depth_noise(depth_m, {}, noise, 1, 1) == 0), 0);
  noise.model = DepthNoise::Model::stereo;
  const int width_px = static_cast<int>(Camera().fx * noise.baseline_m * 0.75);
  EXPECT_EQ(cv::countNonZero(add_depth_noise(depth_m, {}, noise, 1, 1) == 0), 4 * width_px);
  noise.shadow = false;
  EXPECT_EQ(cv::countNonZero(add_depth_noise(depth_m, {}, noise, 1, 1) == 0), 0);
}

TEST(OutlineDistance, IsTheDistanceToTheNearestPixelOfTheOtherSide) {
  // random blobs; OpenCV's exact transform as the second way, capped where ours stops
  constexpr int kReach_px = 7;
  constexpr double kTolerance_px = 1e-4;  // OpenCV's transform in single precision
  cv::Mat noise(90, 130, CV_32FC1), ids, within, beyond;
  cv::RNG(5).fill(noise, cv::RNG::NORMAL, 0, 1);
  cv::GaussianBlur(noise, noise, {}, 4);
  cv::Mat(noise > 0.02).convertTo(ids, CV_16U, 40000 / 255.0);
  const cv::Mat inside = ids == 40000;
  cv::distanceTransform(inside, within, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  cv::distanceTransform(~inside, beyond, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  const cv::Mat distance = outline_distance(ids, 40000, kReach_px);
  int near = 0, far = 0;
  for (int v = 0; v < ids.rows; ++v)
    for (int u = 0; u < ids.cols; ++u) {
      const bool in = inside.at<std::uint8_t>(v, u);
      const double exact = std::max(within.at<float>(v, u), beyond.at<float>(v, u)) - 0.5;
      const double found = distance.at<float>(v, u) * (in ? 1 : -1);
      EXPECT_NEAR(found, std::min(exact, kReach_px + 0.5), kTolerance_px) << u << ", " << v;
      ++(exact < kReach_px ? near : far);
    }
  EXPECT_GT(near, 4000);
  EXPECT_GT(far, 400);
}

SegmenterNoise outline_only(double sigma_px, double length_px) {
  SegmenterNoise noise;
  noise.boundary_sigma_px = sigma_px;
  noise.boundary_length_px = length_px;
  noise.miss_probability = 0;
  return noise;
}

TEST(Segmenter, OutlineMovesBySigmaWithItsLength) {
  // Half planes: the column sums of the mask are the outline's displacements.
  const SegmenterNoise noise = outline_only(2, 12);
  cv::Mat ids = cv::Mat::zeros(100, 600, CV_16UC1);
  ids.rowRange(50, 100) = 9;
  std::vector<double> shifts;
  double product = 0, products = 0;
  constexpr int kFrames = 40;
  for (int frame = 0; frame < kFrames; ++frame) {
    const cv::Mat masks = segment(ids, noise, 5, frame);
    const std::size_t first = shifts.size();
    for (int u = 0; u < ids.cols; ++u) shifts.push_back(cv::countNonZero(masks.col(u)) - 50.0);
    for (std::size_t i = first; i + 12 < shifts.size(); ++i)
      product += shifts[i] * shifts[i + 12], ++products;
  }
  // independent lengths: the integral of the autocorrelation squared is sqrt(pi) times the length
  const double independent = kFrames * 600 / (std::sqrt(std::numbers::pi) * 12);
  const double variance = 4 + 1 / 12.0;  // whole pixels
  EXPECT_NEAR(mean(shifts), 0, kSigmas * 2 * std::sqrt(std::numbers::sqrt2 / independent));
  EXPECT_NEAR(deviation(shifts) / std::sqrt(variance), 1, 0.01 + kSigmas / std::sqrt(2 * independent));
  EXPECT_NEAR(product / products / 4, std::exp(-0.5), 0.02 + kSigmas / std::sqrt(independent));
}

TEST(Segmenter, WithoutNoiseMasksAreTheTruth) {
  cv::Mat ids = cv::Mat::zeros(120, 160, CV_16UC1);
  ids(cv::Rect(0, 10, 60, 40)) = 3;  // at the border
  ids(cv::Rect(50, 30, 60, 60)) = 40000;
  EXPECT_TRUE(same(segment(ids, outline_only(0, 15), 1, 0), ids));
  const cv::Mat full(60, 60, CV_16UC1, cv::Scalar(5));  // no outline in view
  EXPECT_TRUE(same(segment(full, outline_only(2, 15), 1, 0), full));
}

TEST(Segmenter, MissesAtItsRateAndLeavesSmallMasksOut) {
  cv::Mat ids = cv::Mat::zeros(40, 80, CV_16UC1);
  ids(cv::Rect(5, 5, 20, 20)) = 1;
  ids(cv::Rect(45, 5, 7, 7)) = 2;  // 49 pixels, one too few
  SegmenterNoise noise = outline_only(0.5, 10);
  noise.miss_probability = 0.2;
  constexpr int kFrames = 1000;
  int found = 0;
  for (int frame = 0; frame < kFrames; ++frame) {
    const cv::Mat masks = segment(ids, noise, 2, frame);
    found += masks.at<std::uint16_t>(15, 15) == 1;
    EXPECT_EQ(cv::countNonZero(masks == 2), 0);
  }
  EXPECT_NEAR(found, 0.8 * kFrames, kSigmas * std::sqrt(kFrames * 0.2 * 0.8));
  noise.min_pixels = 49;
  noise.miss_probability = 0;
  EXPECT_GT(cv::countNonZero(segment(ids, noise, 2, 0) == 2), 0);
}

TEST(Segmenter, LooksAtEveryNthFrame) {
  SegmenterNoise noise;
  noise.every_n_frames = 3;
  std::vector<int> seen;
  for (int frame = 0; frame < 8; ++frame)
    if (is_segmented(noise, frame)) seen.push_back(frame);
  EXPECT_EQ(seen, (std::vector{0, 3, 6}));
}

TEST(SmoothField, HasUnitVarianceWhateverTheLength) {
  int cases = 0;
  for (const double length_px : {0.5, 3.0, 15.0, 40.0}) {
    std::vector<double> values;
    for (int frame = 0; frame < 30; ++frame) {
      const cv::Mat field = smooth_field({301, 207}, length_px, 1, frame, 2);
      ASSERT_EQ(field.size(), cv::Size(301, 207));
      values.insert(values.end(), field.begin<float>(), field.end<float>());
    }
    const double independent =
        static_cast<double>(values.size()) / std::max(1.0, std::numbers::pi * length_px * length_px);
    EXPECT_NEAR(deviation(values), 1, 0.01 + kSigmas / std::sqrt(2 * independent)) << length_px;
    ++cases;
  }
  EXPECT_EQ(cases, 4);
}

}  // namespace
}  // namespace uniquadric
