#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>

namespace uniquadric {

enum class PngPacking {
  stored,  ///< not compressed: sensor noise leaves little to win (a factor 1.7) for twenty times the time
  packed,  ///< compressed with each row written as its difference from the row above: for images of areas
};

/// Writes an 8UC3 (blue, green, red) or 16UC1 image as PNG, aside and renamed. Any reader opens both
/// packings.
void write_png(const std::filesystem::path& path, const cv::Mat& image, PngPacking packing);

}  // namespace uniquadric
