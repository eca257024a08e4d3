#include "estimator/mask_tracking/color_sides.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>

namespace uniquadric {
namespace {

const cv::Scalar kRed(30, 40, 200), kGrey(120, 120, 120);

struct Halves {
  cv::Mat rgb = cv::Mat(20, 40, CV_8UC3), left = cv::Mat::zeros(20, 40, CV_8UC1), right = left.clone();
  Halves(const cv::Scalar& a, const cv::Scalar& b) {
    rgb.setTo(a);
    rgb.colRange(20, 40).setTo(b);
    left.colRange(0, 16).setTo(255);
    right.colRange(24, 40).setTo(255);
  }
  cv::Mat asked() const { return ~(left | right); }
};

// Each of two plain colours lies on a kernel's peak of its own side and on nothing of the other's; a
// hundredth of the peak stands for what neither has shown.
TEST(ColorSides, OfPlainColoursTheRatioIsThePeakOverNothing) {
  const Halves halves(kRed, kGrey);
  const cv::Mat ratio = color_sides(halves.rgb, halves.left, halves.right, halves.asked(), 9);
  const double most = std::log(1.01 / 0.01);
  EXPECT_NEAR(ratio.at<float>(10, 17), most, 1e-4);
  EXPECT_NEAR(ratio.at<float>(10, 22), -most, 1e-4);
  EXPECT_NEAR(ratio.at<float>(10, 19), most / 3, 1e-4);  // two columns of red, one of grey
  EXPECT_EQ(ratio.at<float>(10, 10), 0);                 // not asked
}

TEST(ColorSides, OneColourOnBothSidesTellsNothing) {
  const Halves halves(kRed, kRed);
  const cv::Mat ratio = color_sides(halves.rgb, halves.left, halves.right, halves.asked(), 9);
  EXPECT_NEAR(cv::norm(ratio, cv::NORM_INF), 0, 1e-6);
}

TEST(ColorSides, WithoutSamplesOfASideNothingIsTold) {
  const Halves halves(kRed, kGrey);
  const cv::Mat none = cv::Mat::zeros(halves.left.size(), CV_8UC1);
  EXPECT_EQ(cv::countNonZero(color_sides(halves.rgb, halves.left, none, halves.asked(), 9)), 0);
  EXPECT_EQ(cv::countNonZero(color_sides(halves.rgb, none, halves.right, halves.asked(), 9)), 0);
  EXPECT_EQ(cv::countNonZero(color_sides(halves.rgb, halves.left, halves.right, halves.asked(), 2)), 0);
}

}  // namespace
}  // namespace uniquadric
