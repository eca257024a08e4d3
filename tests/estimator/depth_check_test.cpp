#include "estimator/perception/depth_check.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <vector>

namespace uniquadric {
namespace {

constexpr std::int64_t kPeriodNs = 33'333'333;

// A wall that slants away from 2 to 6 m, seen further along by `shift_px`.
cv::Mat slanting_wall(double shift_px = 0) {
  cv::Mat depth(120, 160, CV_32FC1);
  for (int v = 0; v < depth.rows; ++v)
    for (int u = 0; u < depth.cols; ++u)
      depth.at<float>(v, u) = static_cast<float>(2 + 4 * (u + shift_px) / depth.cols);
  return depth;
}

TEST(DepthCheck, AViewThatMovesOnIsAMeasurement) {
  DepthCheck check(DepthCheckOptions{});
  for (int n = 0; n < 30; ++n) EXPECT_TRUE(check.is_measurement(n * kPeriodNs, slanting_wall(2 * n))) << n;
}

TEST(DepthCheck, OneValueAndAJumpOfTheWholeImageAreNone) {
  DepthCheck check(DepthCheckOptions{});
  std::int64_t stamp_ns = 0;
  const auto is_measurement = [&](const cv::Mat& depth) {
    return check.is_measurement(stamp_ns += kPeriodNs, depth);
  };
  const cv::Mat uniform(slanting_wall().size(), CV_32FC1, cv::Scalar(3));
  EXPECT_FALSE(is_measurement(uniform));  // before anything else was seen, too
  for (int n = 0; n < 5; ++n) EXPECT_TRUE(is_measurement(slanting_wall()));
  EXPECT_FALSE(is_measurement(uniform));
  EXPECT_FALSE(is_measurement(slanting_wall() * 1.3));
  EXPECT_FALSE(is_measurement(slanting_wall() * 1.3));
  EXPECT_TRUE(is_measurement(slanting_wall()));
  EXPECT_TRUE(is_measurement(uniform * 0));  // nothing was measured, and that is right
  EXPECT_TRUE(is_measurement(slanting_wall()));
}

// Something large comes before the camera: half of the image jumps, the other half stays.
TEST(DepthCheck, WhatComesIntoViewIsNoFailure) {
  DepthCheck check(DepthCheckOptions{});
  EXPECT_TRUE(check.is_measurement(0, slanting_wall()));
  cv::Mat covered = slanting_wall();
  covered(cv::Rect(0, 0, 80, 120)).setTo(0.5);
  EXPECT_TRUE(check.is_measurement(kPeriodNs, covered));
}

// The second one is refused, as nobody knows better yet; the third decides. What has one value decides
// nothing.
TEST(DepthCheck, TwoThatAgreeAreBelievedAgainstTheFirst) {
  for (const double factor : {0.5, 2.0}) {
    DepthCheck check(DepthCheckOptions{});
    std::vector<bool> believed;
    for (int n = 0; n < 6; ++n)
      believed.push_back(check.is_measurement(n * kPeriodNs, slanting_wall() * (n == 0 ? factor : 1)));
    EXPECT_EQ(believed, (std::vector<bool>{true, false, true, true, true, true})) << factor;
  }
  DepthCheck check(DepthCheckOptions{});
  EXPECT_TRUE(check.is_measurement(0, slanting_wall()));
  for (int n = 1; n < 4; ++n)
    EXPECT_FALSE(check.is_measurement(n * kPeriodNs, cv::Mat(120, 160, CV_32FC1, cv::Scalar(9))));
  EXPECT_TRUE(check.is_measurement(4 * kPeriodNs, slanting_wall()));
}

TEST(DepthCheck, WhatStaysOtherwiseIsHowItIs) {
  DepthCheckOptions options;
  DepthCheck check(options);
  for (int n = -20; n <= 0; ++n) EXPECT_TRUE(check.is_measurement(n * kPeriodNs, slanting_wall()));
  int refused = 0;
  for (int n = 1; n < 30; ++n) refused += !check.is_measurement(n * kPeriodNs, slanting_wall() * 1.5);
  EXPECT_EQ(refused, static_cast<int>(options.max_gap_s * 1e9 / kPeriodNs));
  EXPECT_TRUE(check.is_measurement(1'000'000'000'000, slanting_wall()));  // after a gap nothing is compared
}

}  // namespace
}  // namespace uniquadric
