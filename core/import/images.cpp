#include "core/import/images.h"

#include <cmath>
#include <limits>
#include <opencv2/core.hpp>

#include "core/sequence/sequence.h"

namespace uniquadric {

std::optional<cv::Mat> make_color(const std::filesystem::path& path) {
  const cv::Mat image = read_image(path);
  if (image.type() != CV_8UC1 && image.type() != CV_8UC4) return std::nullopt;
  cv::Mat color(image.size(), CV_8UC3);
  const bool is_grey = image.channels() == 1;
  cv::mixChannels({image}, {color}, is_grey ? std::vector{0, 0, 0, 1, 0, 2} : std::vector{0, 0, 1, 1, 2, 2});
  return color;
}

cv::Mat depth_of_disparity(const cv::Mat& disparity, double bf, double disparity_units, double units_per_m) {
  cv::Mat depth = cv::Mat::zeros(disparity.size(), CV_16UC1);
  for (int v = 0; v < disparity.rows; ++v)
    for (int u = 0; u < disparity.cols; ++u) {
      const auto value = disparity.at<std::uint16_t>(v, u);
      if (value == 0) continue;
      const double units = std::round(units_per_m * bf * disparity_units / value);
      if (units <= std::numeric_limits<std::uint16_t>::max())
        depth.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(units);
    }
  return depth;
}

}  // namespace uniquadric
