#include "estimator/mask_tracking/color_sides.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

#include "core/base/quantile.h"
#include "estimator/mask_tracking/local_mean.h"

namespace uniquadric {
namespace {

constexpr int kStride = 2;           // of the samples
constexpr double kLeastSigma = 2;    // levels: rounding, and what compression leaves
constexpr double kOtherwise = 0.01;  // of a kernel's peak: colours that neither side has shown

int squared(const cv::Vec3b& a, const cv::Vec3b& b) {
  int sum = 0;
  for (int c = 0; c < 3; ++c) sum += (a[c] - b[c]) * (a[c] - b[c]);
  return sum;
}

// Standard deviation of one channel between neighbours, by the median of their distance; of a pair it is
// sqrt(2) as large, and the median distance of three normal channels is 1.54 of theirs.
double color_sigma(const cv::Mat& rgb, const cv::Mat& body) {
  std::vector<double> steps;
  for (int v = 0; v < rgb.rows; ++v)
    for (int u = 1; u < rgb.cols; ++u)
      if (body.at<unsigned char>(v, u) && body.at<unsigned char>(v, u - 1))
        steps.push_back(std::sqrt(squared(rgb.at<cv::Vec3b>(v, u), rgb.at<cv::Vec3b>(v, u - 1))));
  if (steps.empty()) return kLeastSigma;
  return std::max(kLeastSigma, upper_median(std::move(steps)) / (1.54 * std::sqrt(2.0)));
}

// exp(-d^2 / 2) up to 4 sigma, by the square of the distance in levels.
std::vector<float> kernel(double sigma) {
  std::vector<float> values(static_cast<std::size_t>(std::min(16 * sigma * sigma, 3.0 * 255 * 255)) + 1);
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = static_cast<float>(std::exp(-static_cast<double>(i) / (2 * sigma * sigma)));
  return values;
}

}  // namespace

cv::Mat color_sides(const cv::Mat& rgb, const cv::Mat& body, const cv::Mat& beyond, const cv::Mat& asked,
                    int half) {
  cv::Mat ratio = cv::Mat::zeros(rgb.size(), CV_32FC1);
  const std::vector<float> likely = kernel(color_sigma(rgb, body));
  const auto ratio_at = [&](int v, int u) {
    const cv::Vec3b& colour = rgb.at<cv::Vec3b>(v, u);
    std::array<double, 2> sums{};
    std::array<int, 2> counts{};
    for (int y = std::max(0, v - half); y <= std::min(rgb.rows - 1, v + half); y += kStride)
      for (int x = std::max(0, u - half); x <= std::min(rgb.cols - 1, u + half); x += kStride) {
        const bool is_body = body.at<unsigned char>(y, x);
        if (!is_body && !beyond.at<unsigned char>(y, x)) continue;
        const std::size_t far = squared(colour, rgb.at<cv::Vec3b>(y, x));
        sums[is_body] += far < likely.size() ? likely[far] : 0;
        ++counts[is_body];
      }
    if (counts[0] == 0 || counts[1] == 0) return 0.0;
    return std::log((sums[1] / counts[1] + kOtherwise) / (sums[0] / counts[0] + kOtherwise));
  };
  for (int v = 0; v < rgb.rows; ++v)
    for (int u = 0; u < rgb.cols; ++u)
      if (asked.at<unsigned char>(v, u)) ratio.at<float>(v, u) = static_cast<float>(ratio_at(v, u));
  cv::Mat mean = local_mean(ratio, asked, 3);
  mean.setTo(0, asked == 0);
  return mean;
}

}  // namespace uniquadric
