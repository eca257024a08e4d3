#include "simulator/scene/image_header.h"

#include <fmt/format.h>

#include <cstdint>
#include <opencv2/core/types.hpp>
#include <optional>

#include "core/base/error.h"

namespace uniquadric {
namespace {

constexpr int kMaxSide_px = 8192;  // ours: 200 MB of colour; scans come with 4096

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
    if (marker == 0xff) {  // fill byte
      ++at;
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

void check(double width, double height, const std::filesystem::path& path) {
  if (width > kMaxSide_px || height > kMaxSide_px)
    throw InputError(path, fmt::format("texture has {:.0f}x{:.0f} px, at most {} a side are read", width,
                                       height, kMaxSide_px));
}

}  // namespace

void check_texture_size(std::string_view bytes, const std::filesystem::path& path) {
  constexpr std::size_t kPngHeader = 24;  // signature, IHDR's length and name, width, height
  if (bytes.starts_with("\x89PNG") && bytes.size() >= kPngHeader)
    check(big_endian(bytes, 16, 4), big_endian(bytes, 20, 4), path);
  if (bytes.starts_with("\xff\xd8"))
    if (const auto size = jpeg_size(bytes)) check(size->width, size->height, path);
}

void check_texture_size(int width, int height, const std::filesystem::path& path) {
  check(width, height, path);
}

}  // namespace uniquadric
