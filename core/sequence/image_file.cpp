#include "core/sequence/image_file.h"

#include <fmt/format.h>

#include <cstdint>
#include <opencv2/core/types.hpp>
#include <optional>

#include "core/base/error.h"

namespace uniquadric {
namespace {

std::uint32_t big_endian(std::string_view bytes, std::size_t at, int count) {
  std::uint32_t value = 0;
  for (int k = 0; k < count; ++k) value = value << 8 | static_cast<unsigned char>(bytes[at + k]);
  return value;
}

// The first start-of-frame segment (ITU T.81, B.1.1.3) holds height and width.
std::optional<cv::Size2d> jpeg_size(std::string_view bytes) {
  for (std::size_t at = 2; at + 9 < bytes.size();) {
    if (bytes[at] != '\xff') return std::nullopt;
    const std::uint32_t marker = big_endian(bytes, at + 1, 1);
    if (marker == 0) return std::nullopt;
    if (marker == 0xff || marker == 0x01 || (marker >= 0xd0 && marker <= 0xd7)) {
      at += marker == 0xff ? 1 : 2;  // a fill byte, or a marker that nothing belongs to
      continue;
    }
    const bool is_frame =
        marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    if (is_frame)
      return cv::Size2d{static_cast<double>(big_endian(bytes, at + 7, 2)),
                        static_cast<double>(big_endian(bytes, at + 5, 2))};
    at += 2 + big_endian(bytes, at + 2, 2);
  }
  return std::nullopt;
}

cv::Size2d png_size(std::string_view bytes) {
  constexpr std::size_t kHeader = 24;               // signature, IHDR's length and name, width, height
  if (bytes.size() < kHeader) return cv::Size2d{};  // libpng finds none either
  return cv::Size2d{static_cast<double>(big_endian(bytes, 16, 4)),
                    static_cast<double>(big_endian(bytes, 20, 4))};
}

}  // namespace

void check_image_size(std::string_view bytes, int most_side_px, const std::filesystem::path& path) {
  const bool is_png = bytes.starts_with("\x89PNG"), is_jpeg = bytes.starts_with("\xff\xd8");
  if (!is_png && !is_jpeg)
    throw InputError(path, "is not an image that can be decoded: neither PNG nor JPEG");
  const auto size = is_png ? png_size(bytes) : jpeg_size(bytes);
  if (!size) throw InputError(path, "is not an image that can be decoded: no size");
  if (size->width > most_side_px || size->height > most_side_px)
    throw InputError(path, fmt::format("has {:.0f}x{:.0f} px, at most {} a side are read", size->width,
                                       size->height, most_side_px));
}

}  // namespace uniquadric
