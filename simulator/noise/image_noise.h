#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>

#include "simulator/scene/scene.h"

namespace uniquadric {

/// The image with white Gaussian noise on every channel of every pixel, rounded to whole grey levels and cut
/// off at 0 and 255. rgb: 8UC3.
cv::Mat add_image_noise(const cv::Mat& rgb, const ImageNoise& noise, std::uint64_t seed, std::int64_t frame);

}  // namespace uniquadric
