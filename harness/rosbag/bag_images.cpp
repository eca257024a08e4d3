#include "harness/rosbag/bag_images.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <opencv2/core.hpp>

#include "core/base/error.h"
#include "core/sequence/image_file.h"
#include "harness/rosbag/bag_reader.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

cv::Mat bgr_of(const cv::Mat& image, bool is_rgb) {
  if (image.type() == CV_8UC3 && !is_rgb) return image;
  cv::Mat color(image.size(), CV_8UC3);
  const std::vector<int> grey = {0, 0, 0, 1, 0, 2}, same = {0, 0, 1, 1, 2, 2}, turned = {0, 2, 1, 1, 2, 0};
  cv::mixChannels({image}, {color}, image.channels() == 1 ? grey : is_rgb ? turned : same);
  return color;
}

}  // namespace

cv::Mat color_of(const BagImage& image, const fs::path& source) {
  const cv::Mat pixels =
      image.file.empty() ? image.pixels : decode_image(image.file, kMostImageSide_px, source);
  if (pixels.empty() || pixels.depth() != CV_8U)
    throw InputError(source, fmt::format("encoding {}: expected 8-bit colour or grey", image.encoding));
  return bgr_of(pixels, image.file.empty() && image.encoding.starts_with("rgb"));
}

cv::Mat depth_of(const BagImage& image, const fs::path& source) {
  if (image.pixels.type() == CV_16UC1 && !image.pixels.empty()) return image.pixels;
  if (image.pixels.type() != CV_32FC1 || image.pixels.empty())
    throw InputError(source, fmt::format("encoding {}: expected 16UC1 or 32FC1", image.encoding));
  cv::Mat depth = cv::Mat::zeros(image.pixels.size(), CV_16UC1);
  for (int v = 0; v < depth.rows; ++v)
    for (int u = 0; u < depth.cols; ++u) {
      const double units = std::round(kBagDepthUnitsPerM * double{image.pixels.at<float>(v, u)});
      if (units > 0 && units <= std::numeric_limits<std::uint16_t>::max())  // no NaN is
        depth.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(units);
    }
  return depth;
}

}  // namespace uniquadric
