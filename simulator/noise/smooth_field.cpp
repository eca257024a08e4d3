#include "simulator/noise/smooth_field.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "simulator/noise/normals.h"

namespace uniquadric {
namespace {

// Unit energy, so that white noise keeps its variance; twice convolved with itself it is the autocorrelation.
cv::Mat smoothing_kernel(double sigma) {
  const int reach = static_cast<int>(std::ceil(4 * sigma));
  cv::Mat kernel(1, 2 * reach + 1, CV_32FC1);
  for (int i = -reach; i <= reach; ++i)
    kernel.at<float>(i + reach) = sigma > 0 ? static_cast<float>(std::exp(-i * i / (2 * sigma * sigma))) : 1;
  return kernel / cv::norm(kernel);
}

}  // namespace

cv::Mat smooth_field(cv::Size size, double length_px, RandomStream stream) {
  constexpr int kNodesALength =
      4;                      // the field is drawn on a grid this fine and interpolated: variance kept to 1 %
  constexpr int kMargin = 2;  // nodes: cubic interpolation looks two to each side
  const int step = std::max(1, static_cast<int>(length_px / kNodesALength));
  const cv::Mat kernel = smoothing_kernel(length_px / std::numbers::sqrt2 / step);
  const int reach = kernel.cols / 2;
  const cv::Size nodes(size.width / step + 1 + 2 * kMargin, size.height / step + 1 + 2 * kMargin);
  cv::Mat white(nodes.height + 2 * reach, nodes.width + 2 * reach, CV_32FC1), smooth, fine;
  fill_normals(stream, {white.ptr<float>(), white.total()});
  cv::sepFilter2D(white, smooth, CV_32F, kernel, kernel);
  if (step == 1) return smooth(cv::Rect({reach + kMargin, reach + kMargin}, size)).clone();
  const cv::Mat valid = smooth(cv::Rect(reach, reach, nodes.width, nodes.height)).clone();
  cv::resize(valid, fine, nodes * step, 0, 0, cv::INTER_CUBIC);
  return fine(cv::Rect(kMargin * step, kMargin * step, size.width, size.height)).clone();
}

}  // namespace uniquadric
