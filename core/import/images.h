#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <optional>

namespace uniquadric {

/// An 8-bit colour image of one with another number of channels: grey three times, or colour without its
/// fourth channel. Nothing for all other images: they are taken or refused as they are.
std::optional<cv::Mat> make_color(const std::filesystem::path& path);

/// Depth in `units_per_m` of disparities `value / disparity_units` px: z = bf / disparity (bf [px m], focal
/// length times baseline). 0 where there is no disparity or z does not fit into 16 bits.
cv::Mat depth_of_disparity(const cv::Mat& disparity, double bf, double disparity_units, double units_per_m);

}  // namespace uniquadric
