#include "simulator/noise/segmenter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "simulator/noise/outline_distance.h"
#include "simulator/noise/smooth_field.h"
#include "tests/simulator/noise_statistics.h"
#include "tests/simulator/same_image.h"

namespace uniquadric {
namespace {

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
    const cv::Mat masks = segment(ids, noise, 5, frame, 30);
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
  EXPECT_TRUE(same(segment(ids, outline_only(0, 15), 1, 0, 30), ids));
  const cv::Mat full(60, 60, CV_16UC1, cv::Scalar(5));  // no outline in view
  EXPECT_TRUE(same(segment(full, outline_only(2, 15), 1, 0, 30), full));
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
    const cv::Mat masks = segment(ids, noise, 2, frame, 30);
    found += masks.at<std::uint16_t>(15, 15) == 1;
    EXPECT_EQ(cv::countNonZero(masks == 2), 0);
  }
  EXPECT_NEAR(found, 0.8 * kFrames, kSigmas * std::sqrt(kFrames * 0.2 * 0.8));
  noise.min_pixels = 49;
  noise.miss_probability = 0;
  EXPECT_GT(cv::countNonZero(segment(ids, noise, 2, 0, 30) == 2), 0);
}

TEST(Segmenter, LooksAtEveryNthFrame) {
  SegmenterNoise noise;
  noise.every_n_frames = 3;
  std::vector<int> seen;
  for (int frame = 0; frame < 8; ++frame)
    if (is_segmented(noise, 1, frame, 30)) seen.push_back(frame);
  EXPECT_EQ(seen, (std::vector{0, 3, 6}));
}

TEST(SmoothField, HasUnitVarianceWhateverTheLength) {
  int cases = 0;
  for (const double length_px : {0.5, 3.0, 15.0, 40.0}) {
    std::vector<double> values;
    for (int frame = 0; frame < 30; ++frame) {
      const cv::Mat field =
          smooth_field({301, 207}, length_px, {1, "segmenter_outline", static_cast<std::uint64_t>(frame), 2});
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
