#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <string_view>

namespace uniquadric {

/// Of an image or a camera: what OpenGL and 16-bit formats carry; a larger size is a mistake.
inline constexpr int kMostImageSide_px = 16384;

/// Throws InputError when the header of an image file announces more than `most_side_px` pixels a side:
/// decoded, a few kilobytes can fill the memory. Throws it, too, for what is neither PNG nor JPEG.
void check_image_size(std::string_view bytes, int most_side_px, const std::filesystem::path& path);

/// The image of a PNG or JPEG file's bytes; `path` names them. Throws InputError for other files, for
/// undecodable or truncated ones, and as check_image_size() does.
cv::Mat decode_image(std::string_view bytes, int most_side_px, const std::filesystem::path& path);

}  // namespace uniquadric
