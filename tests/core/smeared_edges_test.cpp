#include "core/sequence/smeared_edges.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "core/base/quantile.h"
#include "core/base/random.h"

namespace uniquadric {
namespace {

constexpr int kRows = 240, kCols = 320, kEdge = 160;
const cv::Range kBox(60, 180), kColumns(kEdge, 280);

// Inverse depth of a floor that slopes away with a box before it, whose left side is at column kEdge.
cv::Mat scene() {
  cv::Mat w(kRows, kCols, CV_32FC1);
  for (int v = 0; v < kRows; ++v)
    for (int u = 0; u < kCols; ++u) w.at<float>(v, u) = 0.6F + 0.001F * static_cast<float>(v);
  w(kBox, kColumns) = 1.2F;
  return w;
}

cv::Mat smeared(const cv::Mat& w, int side) {
  cv::Mat result;
  cv::blur(w, result, {side, side});
  return result;
}

cv::Mat depth_of(const cv::Mat& w, double noise = 0) {
  RandomStream random(3, "noise");
  cv::Mat z(w.size(), CV_32FC1);
  for (int v = 0; v < w.rows; ++v)
    for (int u = 0; u < w.cols; ++u)
      z.at<float>(v, u) = static_cast<float>(1 / (w.at<float>(v, u) + noise * random.normal()));
  return z;
}

double width_of(const cv::Mat& depth) {
  std::vector<double> widths;
  add_edge_widths(depth, widths);
  EXPECT_GT(widths.size(), 20U);
  return usual_edge_width_px(std::move(widths));
}

TEST(SmearedEdges, AStepHasTheWidthOfTheWindowThatSmearedIt) {
  EXPECT_EQ(width_of(depth_of(scene(), 0.002)), 1);
  for (const int side : {3, 5, 7}) EXPECT_NEAR(width_of(depth_of(smeared(scene(), side), 0.002)), side, 1);
}

TEST(SmearedEdges, ANarrowFaceBeforeAStepIsNoRamp) {
  cv::Mat w = scene();
  w(kBox, cv::Range(kEdge - 5, kEdge)) = 1.1F;
  w(kBox, cv::Range(kColumns.end, kColumns.end + 5)) = 1.1F;
  std::vector<double> widths;
  add_edge_widths(depth_of(w, 0.002), widths);
  ASSERT_GT(widths.size(), 20U);
  EXPECT_EQ(*std::max_element(widths.begin(), widths.end()), 1);
}

// Noise that hangs together makes bumps on what is far, and two walls meet in a crease.
TEST(SmearedEdges, BumpsAndCreasesTellNoWidth) {
  cv::Mat noise(kRows, kCols, CV_32FC1);
  cv::theRNG().state = 5;
  cv::randn(noise, 0, 0.08);
  cv::GaussianBlur(noise, noise, {}, 4);
  cv::Mat w(kRows, kCols, CV_32FC1);
  for (int v = 0; v < kRows; ++v)
    for (int u = 0; u < kCols; ++u)
      w.at<float>(v, u) = 0.2F + 0.002F * static_cast<float>(std::abs(u - kEdge)) + noise.at<float>(v, u);
  std::vector<double> widths;
  add_edge_widths(depth_of(w), widths);
  EXPECT_LT(widths.size(), 5U);
}

TEST(SmearedEdges, WhatIsLeftIsOfOneSurface) {
  constexpr int kSide = 7;
  const cv::Mat sharp = scene();
  cv::Mat depth = depth_of(smeared(sharp, kSide), 0.002);
  drop_smeared_edges(depth, kSide);
  int wrong = 0;
  for (int v = 0; v < kRows; ++v)
    for (int u = 0; u < kCols; ++u)
      wrong +=
          depth.at<float>(v, u) > 0 && std::abs(1 / depth.at<float>(v, u) - sharp.at<float>(v, u)) > 0.05;
  EXPECT_LT(wrong, 30);  // at the box's corners, where ramps meet; before, 2,600
  const cv::Mat row = depth.row(120).colRange(0, 300) == 0;
  EXPECT_NEAR(cv::countNonZero(row), 2 * kSide, 4);  // two ramps, and neither side loses more
  for (int u = kEdge - kSide / 2; u <= kEdge + kSide / 2 - 1; ++u) EXPECT_EQ(depth.at<float>(120, u), 0) << u;
}

TEST(SmearedEdges, CreasesAndSlopesAreNoSteps) {
  cv::Mat w(kRows, kCols, CV_32FC1);
  for (int v = 0; v < kRows; ++v)
    for (int u = 0; u < kCols; ++u)
      w.at<float>(v, u) = static_cast<float>(1 - 0.004 * std::abs(u - kEdge) + 0.002 * v);
  cv::Mat depth = depth_of(w, 0.002);
  drop_smeared_edges(depth, 7);
  EXPECT_LT(cv::countNonZero(depth == 0), 0.02 * kRows * kCols);
}

TEST(SmearedEdges, BesideAShadowTheHiddenEndCountsAsARamp) {
  cv::Mat depth = depth_of(smeared(scene(), 7), 0.002);
  depth(kBox, cv::Range(kEdge - 20, kEdge)) = 0;  // what stereo does not see
  depth.at<float>(120, 250) = 0;                  // a lost pixel is no shadow
  drop_smeared_edges(depth, 7);
  EXPECT_EQ(depth.at<float>(120, kEdge), 0);
  EXPECT_EQ(depth.at<float>(120, kEdge + 2), 0);
  EXPECT_GT(depth.at<float>(120, kEdge + 3), 0);
  EXPECT_GT(depth.at<float>(120, 251), 0);
}

TEST(SmearedEdges, SharpImagesStayAsTheyAre) {
  const cv::Mat depth = depth_of(scene(), 0.002);
  cv::Mat left = depth.clone();
  drop_smeared_edges(left, 1);
  EXPECT_EQ(cv::countNonZero(left != depth), 0);
}

}  // namespace
}  // namespace uniquadric
