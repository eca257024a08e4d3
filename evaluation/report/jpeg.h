#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>

namespace uniquadric {

/// Writes a JPEG, aside and renamed. Throws std::runtime_error on failure.
void write_jpeg(const std::filesystem::path& path, const cv::Mat& image, int quality = 85);

}  // namespace uniquadric
