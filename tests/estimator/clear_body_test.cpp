#include "estimator/mask_tracking/clear_body.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "drawn_world.h"

namespace uniquadric {
namespace {

constexpr double kJump = 0.03, kGrowth = 1.5;
const Sprite kBox{4, 21, {50, 60, 180}, {70, 50}, 2, [](std::int64_t) { return Eigen::Vector2d(100, 80); }};

// The masks as a tracker that fell behind has them: 25 pixels to the left, the right half.
cv::Mat half_of(const cv::Mat& masks) {
  cv::Mat half = masks.clone();
  half.colRange(100 + kBox.size.width / 2 + 5, masks.cols).setTo(0);
  return half;
}

std::map<int, double> areas(const DrawnFrame& drawn) {
  return mask_areas_m2(drawn.masks, drawn.depth, drawn_camera());
}

int differing(const cv::Mat& a, const cv::Mat& b) {
  return cv::countNonZero(a != b);
}

TEST(ClearBody, AreasAreThoseOfTheBodies) {
  const DrawnFrame drawn = draw_world({kBox}, 0);
  const Camera camera = drawn_camera();
  const double expected = 70 * 50 * 4 / (camera.fx * camera.fy);  // at 2 m
  EXPECT_NEAR(areas(drawn).at(4), expected, 1e-6 * expected);
  cv::Mat holes = drawn.depth.clone();
  holes(cv::Rect(100, 80, 30, 50)).setTo(0);
  EXPECT_NEAR(mask_areas_m2(drawn.masks, holes, camera).at(4), expected, 1e-6 * expected);
  EXPECT_TRUE(mask_areas_m2(drawn.masks, cv::Mat::zeros(holes.size(), CV_32FC1), camera).empty());
}

TEST(ClearBody, ABodyInTheAirIsFoundWhole) {
  const DrawnFrame drawn = draw_world({kBox}, 0);
  const cv::Mat fitted =
      fit_to_clear_bodies(half_of(drawn.masks), drawn.depth, drawn_camera(), areas(drawn), kJump, kGrowth);
  EXPECT_EQ(differing(fitted, drawn.masks), 0);
}

TEST(ClearBody, ThePartOfAMaskThatFellBehindIsLeftOut) {
  const DrawnFrame drawn = draw_world({kBox}, 0);
  cv::Mat behind = drawn.masks.clone();
  behind(cv::Rect(85, 80, 15, 50)).setTo(4);  // on the wall
  const cv::Mat fitted =
      fit_to_clear_bodies(behind, drawn.depth, drawn_camera(), areas(drawn), kJump, kGrowth);
  EXPECT_EQ(differing(fitted, drawn.masks), 0);
}

TEST(ClearBody, WhatTouchesSomethingLargerStays) {
  DrawnFrame drawn = draw_world({kBox}, 0);
  const auto known = areas(drawn);
  drawn.depth.rowRange(130, drawn.depth.rows).setTo(2.01);  // a shelf under its foot
  const cv::Mat half = half_of(drawn.masks);
  EXPECT_EQ(differing(fit_to_clear_bodies(half, drawn.depth, drawn_camera(), known, kJump, kGrowth), half),
            0);
  EXPECT_EQ(differing(fit_to_clear_bodies(half, drawn.depth, drawn_camera(), {}, kJump, kGrowth), half), 0);
  EXPECT_EQ(differing(fit_to_clear_bodies(half, {}, drawn_camera(), known, kJump, kGrowth), half), 0);
}

// Of what a hand holds nobody knows where its mask, a few pixels off, ends.
TEST(ClearBody, WhatTouchesAnotherBodyStays) {
  Sprite hand = kBox;
  hand.id = 5;
  hand.depth_m = 2.02;
  hand.corner_px = [](std::int64_t) { return Eigen::Vector2d(100 + kBox.size.width, 80); };
  for (const double depth_m : {2.02, 2.2}) {
    hand.depth_m = depth_m;
    const DrawnFrame drawn = draw_world({kBox, hand}, 0);
    cv::Mat half = drawn.masks.clone();
    half(cv::Rect(100, 80, 30, 50)).setTo(0);
    const cv::Mat fitted =
        fit_to_clear_bodies(half, drawn.depth, drawn_camera(), areas(drawn), kJump, kGrowth);
    EXPECT_EQ(differing(fitted, depth_m < 2.1 ? half : drawn.masks), 0) << depth_m;
  }
}

}  // namespace
}  // namespace uniquadric
