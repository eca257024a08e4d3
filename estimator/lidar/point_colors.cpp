#include "estimator/lidar/point_colors.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace uniquadric {
namespace {

constexpr int kHalfWindow = 2;  // [px]: noise and the finest texture are not the same in another view

}  // namespace

Eigen::Matrix3Xf point_colors(const cv::Mat& rgb, const Camera& lens, const Eigen::Matrix3Xd& points) {
  cv::Mat colors(1, static_cast<int>(points.cols()), CV_32FC3, cv::Scalar::all(0));
  const cv::Rect image(0, 0, rgb.cols, rgb.rows);
  for (int i = 0; i < colors.cols; ++i) {
    const auto pixel = lens.project(points.col(i));
    if (!pixel) continue;
    const int u = static_cast<int>(std::lround(std::clamp(pixel->x(), 0.0, rgb.cols - 1.0)));
    const int v = static_cast<int>(std::lround(std::clamp(pixel->y(), 0.0, rgb.rows - 1.0)));
    const int side = 2 * kHalfWindow + 1;
    const cv::Scalar mean = cv::mean(rgb(cv::Rect(u - kHalfWindow, v - kHalfWindow, side, side) & image));
    for (int k = 0; k < 3; ++k) colors.at<cv::Vec3f>(i)[k] = static_cast<float>(mean[k] / 255);
  }
  if (!colors.empty()) cv::cvtColor(colors, colors, cv::COLOR_BGR2Lab);
  return Eigen::Map<const Eigen::Matrix3Xf>(colors.ptr<float>(), 3, points.cols());
}

}  // namespace uniquadric
