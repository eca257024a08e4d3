#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace uniquadric {

/// Of an image or a camera: what OpenGL and 16-bit formats carry; a larger size is a mistake.
inline constexpr int kMostImageSide_px = 16384;

/// The image of a PNG or JPEG file's bytes; `path` names them. Throws InputError for other files, for
/// undecodable or truncated ones, and when the header announces more than `most_side_px` pixels a side.
cv::Mat decode_image(std::string_view bytes, int most_side_px, const std::filesystem::path& path);

/// Whether a file's bytes begin and end as a JPEG's; a few bytes behind its end do no harm.
bool is_whole_jpeg(std::string_view bytes);

/// The bytes of an image's file, by its ending (".png", ".jpg") and the parameters of cv::imencode. Throws
/// std::runtime_error naming `path` for an image that such a file cannot hold.
std::string encode_image(const std::string& ending, const cv::Mat& image, const std::vector<int>& parameters,
                         const std::filesystem::path& path);

}  // namespace uniquadric
