#include "estimator/mask_tracking/body_shift.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "drawn_world.h"
#include "estimator/mask_tracking/flow_tracker.h"

namespace uniquadric {
namespace {

constexpr double kLess = 0.97;  // of the depth, in the second frame
const cv::Point kShift{28, -18};

Sprite body(double depth_m, const cv::Point& corner) {
  return {4,        21,      {50, 60, 180},
          {34, 26}, depth_m, [=](std::int64_t) {
            return Eigen::Vector2d(corner.x, corner.y); }};
}

const DrawnFrame kFrom = draw_world({body(2, {100, 80})}, 0);
const DrawnFrame kTo = draw_world({body(2 * kLess, cv::Point(100, 80) + kShift)}, 1);

TEST(BodyShift, IsThatOfColoursAndDepth) {
  EXPECT_EQ(body_shift(kFrom.masks == 4, {kFrom.rgb, kFrom.depth}, {kTo.rgb, kTo.depth}, {0.01, 0.05}).pixels,
            kShift);
  EXPECT_EQ(body_shift(kFrom.masks == 4, {kFrom.rgb, {}}, {kTo.rgb, {}}, {0.01, 0.05}).pixels, kShift);
}

TEST(BodyShift, DepthAloneTellsABodyWithoutColours) {
  const cv::Mat grey(kFrom.rgb.size(), CV_8UC3, cv::Scalar(90, 90, 90));
  EXPECT_EQ(body_shift(kFrom.masks == 4, {grey, kFrom.depth}, {grey, kTo.depth}, {0.01, 0.05}).pixels,
            kShift);
}

TEST(BodyShift, NothingHasNone) {
  EXPECT_EQ(
      body_shift(cv::Mat::zeros(kFrom.masks.size(), CV_8UC1), {kFrom.rgb, {}}, {kTo.rgb, {}}, {0.01, 0.05})
          .pixels,
      cv::Point());
}

cv::Mat carried(double lost_share, const DrawnFrame& before, const DrawnFrame& after) {
  FlowTrackerOptions options;
  options.lost_share = lost_share;
  const FlowTracker tracker(options);
  TrackedImage from{0, before.rgb, before.depth, {}, {}}, to{1, after.rgb, after.depth, {}, {}};
  tracker.prepare(from, nullptr);
  tracker.prepare(to, &from);
  return tracker.carry(before.masks, from, to).masks == 4;
}

TEST(BodyShift, CarriesASmallBodyFurtherThanFlow) {
  EXPECT_LT(mask_iou(carried(0, kFrom, kTo), kTo.masks == 4), 0.5);
  EXPECT_GT(mask_iou(carried(FlowTrackerOptions().lost_share, kFrom, kTo), kTo.masks == 4), 0.95);
}

// Nothing else is taken in its place.
TEST(BodyShift, WhatIsGoneIsNotFound) {
  const double asked = FlowTrackerOptions().lost_share;
  Sprite other = body(1.7, {115, 90});
  other.id = 7, other.texture = 5, other.color = {200, 160, 40};
  const DrawnFrame hidden = draw_world({body(2, {100, 80}), other}, 1);
  EXPECT_LE(cv::countNonZero(carried(asked, kFrom, hidden)), cv::countNonZero(hidden.masks == 4));
  const DrawnFrame inside = draw_world({body(2, {0, 80})}, 0), gone = draw_world({body(2, {-20, 80})}, 1);
  EXPECT_LE(cv::countNonZero(carried(asked, inside, gone)), 1.1 * cv::countNonZero(gone.masks == 4));
}

}  // namespace
}  // namespace uniquadric
