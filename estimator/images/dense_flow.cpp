#include "estimator/images/dense_flow.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

namespace uniquadric {
namespace {

int opencv_preset(FlowOptions::Preset preset) {
  switch (preset) {
    case FlowOptions::Preset::ultrafast:
      return cv::DISOpticalFlow::PRESET_ULTRAFAST;
    case FlowOptions::Preset::fast:
      return cv::DISOpticalFlow::PRESET_FAST;
    case FlowOptions::Preset::medium:
      return cv::DISOpticalFlow::PRESET_MEDIUM;
  }
  return cv::DISOpticalFlow::PRESET_ULTRAFAST;
}

}  // namespace

cv::Mat flow_image(const cv::Mat& rgb, const FlowOptions& options) {
  cv::Mat grey, small;
  cv::cvtColor(rgb, grey, cv::COLOR_BGR2GRAY);
  if (options.downscale == 1) return grey;
  const double scale = 1.0 / options.downscale;
  cv::resize(grey, small, {}, scale, scale, cv::INTER_AREA);
  return small;
}

cv::Mat backward_flow(const cv::Mat& to, const cv::Mat& from, const FlowOptions& options) {
  const auto algorithm = cv::DISOpticalFlow::create(opencv_preset(options.preset));
  algorithm->setUseSpatialPropagation(false);
  cv::Mat flow;
  algorithm->calc(to, from, flow);
  return flow;
}

cv::Mat origins(const cv::Mat& flow, const cv::Rect& region, int downscale) {
  cv::Mat positions(region.size(), CV_32FC2);
  const auto scale = static_cast<float>(downscale);
  const float offset = (scale - 1) / 2;  // a small pixel's centre lies between those it stands for
  for (int v = 0; v < region.height; ++v) {
    auto* row = positions.ptr<cv::Vec2f>(v);
    const float y = static_cast<float>(region.y + v);
    const float small_y = std::clamp((y - offset) / scale, 0.0F, static_cast<float>(flow.rows - 1));
    const int y0 = std::min(static_cast<int>(small_y), flow.rows - 1), y1 = std::min(y0 + 1, flow.rows - 1);
    const float wy = small_y - static_cast<float>(y0);
    const auto *upper = flow.ptr<cv::Vec2f>(y0), *lower = flow.ptr<cv::Vec2f>(y1);
    for (int u = 0; u < region.width; ++u) {
      const float x = static_cast<float>(region.x + u);
      const float small_x = std::clamp((x - offset) / scale, 0.0F, static_cast<float>(flow.cols - 1));
      const int x0 = std::min(static_cast<int>(small_x), flow.cols - 1), x1 = std::min(x0 + 1, flow.cols - 1);
      const float wx = small_x - static_cast<float>(x0);
      const cv::Vec2f top = upper[x0] * (1 - wx) + upper[x1] * wx;
      const cv::Vec2f bottom = lower[x0] * (1 - wx) + lower[x1] * wx;
      row[u] = cv::Vec2f(x, y) + (top * (1 - wy) + bottom * wy) * scale;
    }
  }
  return positions;
}

}  // namespace uniquadric
