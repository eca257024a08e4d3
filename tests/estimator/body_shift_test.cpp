#include "estimator/mask_tracking/body_shift.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

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

cv::Point shift_of(const SmallImage& from, const SmallImage& to) {
  const BodyShift shift = body_shift(kFrom.masks == 4, from, to, {0.01, 0.05}, 0.6);
  EXPECT_EQ(shift.turn_rad, 0);
  return shift.pixels;
}

TEST(BodyShift, IsThatOfColoursAndDepth) {
  EXPECT_EQ(shift_of({kFrom.rgb, kFrom.depth}, {kTo.rgb, kTo.depth}), kShift);
  EXPECT_EQ(shift_of({kFrom.rgb, {}}, {kTo.rgb, {}}), kShift);
}

TEST(BodyShift, DepthAloneTellsABodyWithoutColours) {
  const cv::Mat grey(kFrom.rgb.size(), CV_8UC3, cv::Scalar(90, 90, 90));
  EXPECT_EQ(shift_of({grey, kFrom.depth}, {grey, kTo.depth}), kShift);
}

TEST(BodyShift, NothingHasNone) {
  EXPECT_EQ(body_shift(cv::Mat::zeros(kFrom.masks.size(), CV_8UC1), {kFrom.rgb, {}}, {kTo.rgb, {}},
                       {0.01, 0.05}, 0.6)
                .pixels,
            cv::Point());
}

TEST(BodyShift, OriginsAreWhereWhatMovedWas) {
  const BodyShift shift{{7, -3}, 0.5, {40, 30}, 1};
  EXPECT_LT(
      cv::norm(shift.moved({50, 30}) - cv::Point2f(40 + 10 * std::cos(0.5F) + 7, 27 + 10 * std::sin(0.5F))),
      1e-4);
  EXPECT_LT(cv::norm(shift.origin_of(shift.moved({12, 34})) - cv::Point2f(12, 34)), 1e-4);
}

cv::Mat carried(double lost_share, const DrawnFrame& before, const DrawnFrame& after,
                double most_turn_rad = FlowTrackerOptions().most_turn_rad) {
  FlowTrackerOptions options;
  options.lost_share = lost_share;
  options.most_turn_rad = most_turn_rad;
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

TEST(BodyShift, CarriesABodyThatTurnsAsItFlies) {
  constexpr double kTurn_rad = 0.5;
  Sprite rod = body(2, {100, 80});
  rod.size = {60, 16};
  const DrawnFrame before = draw_world({rod}, 0);
  DrawnFrame turned = draw_world({}, 1);
  const cv::Point2f middle(129.5, 87.5);
  const auto c = static_cast<float>(std::cos(kTurn_rad)), s = static_cast<float>(std::sin(kTurn_rad));
  const cv::Point2f to =
      middle + cv::Point2f(kShift) - cv::Point2f(c * middle.x - s * middle.y, s * middle.x + c * middle.y);
  const cv::Matx23f motion(c, -s, to.x, s, c, to.y);
  cv::Mat rgb, depth, mask;
  for (const auto& [from, warped] :
       {std::pair{before.rgb, &rgb}, {before.depth, &depth}, {before.masks, &mask}})
    cv::warpAffine(from, *warped, motion, from.size(), cv::INTER_NEAREST);
  rgb.copyTo(turned.rgb, mask == 4), depth.copyTo(turned.depth, mask == 4);
  EXPECT_LT(mask_iou(carried(FlowTrackerOptions().lost_share, before, turned, 0), mask == 4), 0.7);
  EXPECT_GT(mask_iou(carried(FlowTrackerOptions().lost_share, before, turned), mask == 4), 0.85);
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
