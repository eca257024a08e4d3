#include "drawn_world.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/random.h"

namespace uniquadric {
namespace {

constexpr float kContrast = 45;  // grey levels

// Smooth blotches of a few pixels around a colour.
cv::Mat texture(cv::Size size, std::uint32_t number, const cv::Vec3f& color) {
  RandomStream random(1, "texture", 0, number);
  cv::Mat noise(size.height / 4 + 3, size.width / 4 + 3, CV_32FC3), large, image;
  for (auto& value : cv::Mat_<cv::Vec3f>(noise)) {
    const auto shade = static_cast<float>(random.uniform(-kContrast, kContrast));
    value = color + cv::Vec3f::all(shade);
  }
  cv::resize(noise, large, noise.size() * 4, 0, 0, cv::INTER_CUBIC);
  large(cv::Rect({4, 4}, size)).convertTo(image, CV_8U);
  return image;
}

}  // namespace

Camera drawn_camera() {
  return {320, 240, 260, 260, 159.5, 119.5, {}};
}

DrawnFrame draw_world(const std::vector<Sprite>& sprites, std::int64_t frame) {
  const cv::Size size(drawn_camera().width, drawn_camera().height);
  DrawnFrame drawn;
  drawn.frame.frame = frame;
  drawn.frame.stamp_ns = std::llround(static_cast<double>(frame) * 1e9 / 30);
  drawn.frame.masks = "masks.png";  // the segmenter has something for it
  drawn.rgb = texture(size, 0, {110, 120, 115});
  drawn.depth = cv::Mat(size, CV_32FC1, cv::Scalar(4));
  drawn.masks = cv::Mat::zeros(size, CV_16UC1);
  std::vector<Sprite> order = sprites;
  std::stable_sort(order.begin(), order.end(),
                   [](const Sprite& a, const Sprite& b) { return a.depth_m > b.depth_m; });
  for (const Sprite& sprite : order) {
    const Eigen::Vector2d corner = sprite.corner_px(frame);
    const cv::Point at(static_cast<int>(std::lround(corner.x())), static_cast<int>(std::lround(corner.y())));
    const cv::Rect whole(at, sprite.size), seen = whole & cv::Rect({0, 0}, size);
    if (seen.empty()) continue;
    texture(sprite.size, sprite.texture, sprite.color)(seen - at).copyTo(drawn.rgb(seen));
    drawn.depth(seen).setTo(sprite.depth_m);
    drawn.masks(seen).setTo(sprite.id);
  }
  return drawn;
}

double mask_iou(const cv::Mat& a, const cv::Mat& b) {
  const int either = cv::countNonZero(a | b);
  return either == 0 ? 1 : static_cast<double>(cv::countNonZero(a & b)) / either;
}

}  // namespace uniquadric
