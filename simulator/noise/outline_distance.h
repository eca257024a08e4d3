#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>

namespace uniquadric {

/// Distance of every pixel (32FC1, [px]) to the outline of the pixels that hold `id` (ids: 16UC1), positive
/// inside. The outline runs midway between the pixels on its two sides: the distance is that to the nearest
/// pixel of the other side, less one half. It is exact up to `reach_px` and reach_px + 1/2 beyond: so the
/// time grows with reach_px, and does not with the shape. 0 < reach_px <= kMostOutlineReach_px.
cv::Mat outline_distance(const cv::Mat& ids, int id, int reach_px);

constexpr int kMostOutlineReach_px = 120;  ///< two squares of it fit 16 bits

}  // namespace uniquadric
