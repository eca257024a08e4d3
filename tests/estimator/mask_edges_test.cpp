#include "estimator/mask_tracking/mask_edges.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/random.h"
#include "drawn_world.h"

namespace uniquadric {
namespace {

const Sprite kBox{4, 21, {50, 60, 180}, {70, 50}, 2, [](std::int64_t) { return Eigen::Vector2d(100, 80); }};

cv::Mat shifted(const cv::Mat& masks, int dx, int dy) {
  cv::Mat moved;
  const cv::Matx23d by(1, 0, dx, 0, 1, dy);
  cv::warpAffine(masks, moved, by, masks.size(), cv::INTER_NEAREST);
  return moved;
}

TEST(MaskEdges, AMaskMovesOntoTheDepthEdgesNearIt) {
  const DrawnFrame drawn = draw_world({kBox}, 0);
  int cases = 0;
  for (const auto& [dx, dy] : {std::pair(3, 0), {-3, 2}, {0, -4}, {4, 4}}) {
    const cv::Mat fitted = fit_to_edges(shifted(drawn.masks, dx, dy), {{}, drawn.depth, {}}, {});
    EXPECT_EQ(cv::countNonZero(fitted != drawn.masks), 0) << dx << " " << dy;
    ++cases;
  }
  EXPECT_EQ(cases, 4);
}

TEST(MaskEdges, NoiseAndHolesOfDepthDoLittleHarm) {
  const DrawnFrame drawn = draw_world({kBox}, 0);
  RandomStream random(1, "depth");
  cv::Mat depth = drawn.depth.clone();
  for (auto& z : cv::Mat_<float>(depth))
    z = random.uniform() < 0.1 ? 0.0F : z * static_cast<float>(1 + 0.005 * random.normal());
  const cv::Mat fitted = fit_to_edges(shifted(drawn.masks, 3, -2), {{}, depth, {}}, {});
  EXPECT_GT(mask_iou(fitted != 0, drawn.masks != 0), 0.99);
}

TEST(MaskEdges, WithoutAStepOfDepthAMaskStaysAsItIs) {
  const DrawnFrame drawn = draw_world({kBox}, 0);
  const cv::Mat moved = shifted(drawn.masks, 3, 0);
  const cv::Mat flat(drawn.depth.size(), CV_32FC1, cv::Scalar(2));
  EXPECT_EQ(cv::countNonZero(fit_to_edges(moved, {{}, flat, {}}, {}) != moved), 0);
  EXPECT_EQ(
      cv::countNonZero(fit_to_edges(moved, {{}, cv::Mat::zeros(flat.size(), CV_32FC1), {}}, {}) != moved), 0);
  EXPECT_EQ(cv::countNonZero(fit_to_edges(moved, {{}, {}, {}}, {}) != moved), 0);
  MaskEdgeOptions off;
  off.reach_px = 0;
  EXPECT_EQ(cv::countNonZero(fit_to_edges(moved, {{}, drawn.depth, {}}, off) != moved), 0);
}

// Where two masks claim a pixel it goes to the body of its depth.
TEST(MaskEdges, NeighboursPartAtTheStepBetweenThem) {
  Sprite front = kBox;
  front.id = 5;
  front.depth_m = 1.7;
  front.corner_px = [](std::int64_t) { return Eigen::Vector2d(140, 70); };
  const DrawnFrame drawn = draw_world({kBox, front}, 0);
  cv::Mat moved = drawn.masks.clone();
  const cv::Mat shift = shifted(drawn.masks == 5, 3, 1);
  moved.setTo(4, moved == 5);
  moved.setTo(5, shift);
  const cv::Mat fitted = fit_to_edges(moved, {{}, drawn.depth, {}}, {});
  EXPECT_GT(mask_iou(fitted == 5, drawn.masks == 5), 0.99);
  EXPECT_GT(mask_iou(fitted == 4, drawn.masks == 4), 0.97);
}

// No depth tells two boxes of one depth apart: each keeps what its mask says.
TEST(MaskEdges, BodiesSideBySideKeepTheirOwn) {
  for (const int gap : {0, 1, 2}) {
    Sprite beside = kBox;
    beside.id = 5;
    beside.corner_px = [&](std::int64_t) { return Eigen::Vector2d(100 + kBox.size.width + gap, 80); };
    DrawnFrame drawn = draw_world({kBox, beside}, 0);
    const int seam = 100 + kBox.size.width;
    drawn.depth(cv::Rect(seam, 80, gap, kBox.size.height)).setTo(2.02);  // as at an oblique gap
    const cv::Mat fitted = fit_to_edges(drawn.masks, {{}, drawn.depth, {}}, {});
    EXPECT_EQ(cv::countNonZero((fitted != drawn.masks) & (drawn.masks != 0)), 0) << gap;
  }
}

// A face that recedes until it is nearly as far as the wall is the body's all the same: its depth runs on.
TEST(MaskEdges, AFaceThatRecedesBelongsToItsBody) {
  DrawnFrame drawn = draw_world({kBox}, 0);
  drawn.depth.setTo(2.9);
  const int left = 100, edge = left + kBox.size.width;  // of the box
  for (int v = 80; v < 80 + kBox.size.height; ++v)
    for (int u = left; u < edge; ++u)
      drawn.depth.at<float>(v, u) = 2.0F + 0.025F * static_cast<float>(std::max(0, u - (edge - 30)));
  cv::Mat short_mask = drawn.masks.clone();
  short_mask.colRange(edge - 4, edge).setTo(0);
  const cv::Mat fitted = fit_to_edges(short_mask, {{}, drawn.depth, {}}, {});
  EXPECT_EQ(cv::countNonZero(fitted != drawn.masks), 0);
}

// A second body that looks out from behind the first is nearer to it in depth than the wall is; no part of
// it.
TEST(MaskEdges, WhatComesIntoViewBehindABodyIsNotTakenIn) {
  Sprite behind = kBox;
  behind.id = 5;
  behind.depth_m = 2.3;
  behind.corner_px = [](std::int64_t) { return Eigen::Vector2d(103, 85); };  // three pixels of it show
  const DrawnFrame drawn = draw_world({kBox, behind}, 0);
  cv::Mat first = drawn.masks.clone();
  first.setTo(0, first == 5);
  ASSERT_GT(cv::countNonZero(drawn.masks == 5), 100);
  EXPECT_EQ(cv::countNonZero(fit_to_edges(first, {{}, drawn.depth, {}}, {}) != first), 0);
}

// A body that stands on a table which recedes: its foot, where depth goes on without a step, stays as it is.
// A table's mean depth differs on its two sides, which is no edge; above it the outline has one.
TEST(MaskEdges, WhereABodyStandsItsMaskDoesNotGrowOverTheTable) {
  DrawnFrame drawn = draw_world({kBox}, 0);
  drawn.depth.setTo(4);
  const int foot = 80 + kBox.size.height;
  for (int v = foot - 25; v < drawn.depth.rows; ++v)  // meets the box at its foot, 2 m away
    drawn.depth.row(v).setTo(2 - 0.02 * (v - foot + 1));
  drawn.depth.setTo(2, drawn.masks != 0);
  const cv::Mat fitted = fit_to_edges(drawn.masks, {{}, drawn.depth, {}}, {});
  EXPECT_EQ(cv::countNonZero(fitted != drawn.masks), 0);
  const cv::Mat moved = shifted(drawn.masks, 0, 3);  // its foot on the table, its head too low
  const cv::Mat raised = fit_to_edges(moved, {{}, drawn.depth, {}}, {});
  EXPECT_EQ(cv::countNonZero((raised != 0) != ((drawn.masks != 0) | (moved != 0))), 0);
}

// A strip of five pixels has no inside four pixels from its outline: its expected depth tells it.
TEST(MaskEdges, AThinBodyIsFoundByItsExpectedDepth) {
  Sprite strip = kBox;
  strip.size = {90, 5};
  const DrawnFrame drawn = draw_world({strip}, 0);
  const cv::Mat moved = shifted(drawn.masks, 2, 3);
  cv::Mat expected = cv::Mat::zeros(moved.size(), CV_32FC1);
  expected.setTo(2.03, moved == 4);
  EXPECT_LT(mask_iou(moved != 0, drawn.masks != 0), 0.4);
  EXPECT_GT(mask_iou(fit_to_edges(moved, {{}, drawn.depth, expected}, {}) != 0, drawn.masks != 0), 0.98);
}

// Where it stands no step of depth parts a body from the table, but their colours do.
TEST(MaskEdges, ColoursTellWhereABodyStands) {
  DrawnFrame drawn = draw_world({kBox}, 0);
  const int foot = 80 + kBox.size.height;
  for (int v = foot - 25; v < drawn.depth.rows; ++v) drawn.depth.row(v).setTo(2 - 0.02 * (v - foot + 1));
  drawn.depth.setTo(2, drawn.masks != 0);
  int cases = 0;
  for (const int dy : {-3, 3}) {
    const cv::Mat moved = shifted(drawn.masks, 0, dy);
    const cv::Mat fitted = fit_to_edges(moved, {drawn.rgb, drawn.depth, {}}, {});
    EXPECT_GT(mask_iou(fitted != 0, drawn.masks != 0), 0.97) << dy;
    EXPECT_LT(mask_iou(moved != 0, drawn.masks != 0), 0.91);
    ++cases;
  }
  EXPECT_EQ(cases, 2);
}

// In the shadow that a body throws for the second eye of the depth camera nothing is measured: it is not the
// body's.
TEST(MaskEdges, AMaskDoesNotCreepIntoAShadowOfDepth) {
  DrawnFrame drawn = draw_world({kBox}, 0);
  drawn.depth(cv::Rect(100 - 12, 80, 12, kBox.size.height)).setTo(0);
  cv::Mat by_depth = drawn.masks, by_colours = drawn.masks;
  for (int n = 0; n < 10; ++n) {
    by_depth = fit_to_edges(by_depth, {{}, drawn.depth, {}}, {});
    by_colours = fit_to_edges(by_colours, {drawn.rgb, drawn.depth, {}}, {});
  }
  EXPECT_EQ(cv::countNonZero(by_depth != drawn.masks), 0);
  EXPECT_GT(mask_iou(by_colours != 0, drawn.masks != 0), 0.995);
}

}  // namespace
}  // namespace uniquadric
