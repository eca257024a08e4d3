#include "estimator/lidar/point_colors.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

namespace uniquadric {
namespace {

// Left half pure red, right half a mid grey; L*a*b* of the sRGB colours after CIE 15 (D65).
TEST(PointColors, AreThoseOfThePixelsThatShowThem) {
  Camera lens{320, 240, 260, 260, 159.5, 119.5, {-0.3, 0.1, 0, 0, 0}};
  cv::Mat image(240, 320, CV_8UC3, cv::Scalar(0, 0, 255));
  image.colRange(160, 320).setTo(cv::Scalar(119, 119, 119));
  Eigen::Matrix3Xd points(3, 4);
  points.col(0) = 2 * *lens.unproject({20, 30});
  points.col(1) = 3 * *lens.unproject({153, 200});  // with an ideal lens' pixel beside it
  points.col(2) = 2 * *lens.unproject({300, 30});
  points.col(3) = Eigen::Vector3d(5, 0, 2);  // beyond the border
  const Eigen::Matrix3Xf colors = point_colors(image, lens, points);
  const Eigen::Vector3f red(53.24F, 80.09F, 67.2F), grey(50, 0, 0);
  for (int i = 0; i < 4; ++i) EXPECT_LT((colors.col(i) - (i < 2 ? red : grey)).norm(), 0.5F) << i;
}

}  // namespace
}  // namespace uniquadric
