#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>

namespace uniquadric {

struct BagImage;

/// Units a metre of depth_of(): those of 16UC1 images, by REP 118.
inline constexpr double kBagDepthUnitsPerM = 1000;

/// An image as a sequence has it: CV_8UC3 in OpenCV's order, grey three times; CV_16UC1 in
/// kBagDepthUnitsPerM, 0 for what is not finite, not in front of the camera or beyond 16 bits. Throw
/// InputError naming `source` for images of other encodings.
cv::Mat color_of(const BagImage& image, const std::filesystem::path& source);
cv::Mat depth_of(const BagImage& image, const std::filesystem::path& source);

}  // namespace uniquadric
