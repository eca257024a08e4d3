#include "estimator/segmentation/moved_pixels.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <optional>

#include "estimator/images/dense_flow.h"
#include "estimator/shape/depth_point.h"

namespace uniquadric {
namespace {

std::optional<MovedPixel> moved_pixel(const cv::Point& pixel, const RgbdImage& now, const RgbdImage& before,
                                      const cv::Vec2f& origin, const Camera& camera) {
  const double z = now.depth.at<float>(pixel);
  const cv::Point from(static_cast<int>(std::lround(origin[0])), static_cast<int>(std::lround(origin[1])));
  if (!(z > 0) || !cv::Rect({0, 0}, before.depth.size()).contains(from)) return std::nullopt;
  const double z_before = before.depth.at<float>(from);
  if (!(z_before > 0)) return std::nullopt;
  const auto point = depth_point(now.depth, camera, pixel.x, pixel.y);
  if (!point) return std::nullopt;
  constexpr double kDepthNoise = 0.01;  // relative, of a difference of two measurements
  return MovedPixel{pixel, {*point, {origin[0], origin[1]}, z_before, kDepthNoise * z}};
}

}  // namespace

EarlierImage with_flow(const RgbdImage& before, const RgbdImage& now) {
  const FlowOptions options{FlowOptions::Preset::medium, 1};
  return {before, backward_flow(flow_image(now.rgb, options), flow_image(before.rgb, options), options)};
}

std::vector<MovedPixel> moved_pixels(const cv::Mat& mask, const cv::Rect& box, const RgbdImage& now,
                                     const EarlierImage& before, const Camera& camera, int samples) {
  const cv::Mat positions = origins(before.flow, box, 1);
  const int step = std::max(1, static_cast<int>(std::sqrt(cv::countNonZero(mask) / double(samples))));
  std::vector<MovedPixel> pixels;
  for (int v = 0; v < box.height; v += step)
    for (int u = 0; u < box.width; u += step)
      if (mask.at<unsigned char>(v, u))
        if (const auto moved =
                moved_pixel({box.x + u, box.y + v}, now, before, positions.at<cv::Vec2f>(v, u), camera))
          pixels.push_back(*moved);
  return pixels;
}

double error_px(const MovedPixel& moved, const Camera& camera, const Pose& motion) {
  const auto pixel = camera.project(motion * moved.sighting.point);
  return pixel ? (*pixel - moved.sighting.pixel).norm() : 1e9;
}

}  // namespace uniquadric
