#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <string_view>

namespace uniquadric {

/// Of an image or a camera: what OpenGL and 16-bit formats carry; a larger size is a mistake.
inline constexpr int kMostImageSide_px = 16384;

/// The image of a PNG or JPEG file's bytes; `path` names them. Throws InputError for other files, for
/// undecodable or truncated ones, and when the header announces more than `most_side_px` pixels a side.
cv::Mat decode_image(std::string_view bytes, int most_side_px, const std::filesystem::path& path);

}  // namespace uniquadric
