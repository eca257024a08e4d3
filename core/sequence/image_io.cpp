#include <fmt/format.h>
#include <libdeflate.h>

#include <opencv2/imgcodecs.hpp>

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/sequence/image_file.h"
#include "core/sequence/sequence.h"

namespace uniquadric {
namespace {

constexpr std::size_t kMostImageBytes = 1 << 30;
constexpr std::size_t kPngSignature = 8, kChunkFrame = 12;  // bytes; a chunk's frame: length, type, checksum

std::uint32_t big_endian(std::string_view bytes) {
  std::uint32_t value = 0;
  for (int i = 0; i < 4; ++i) value = value << 8 | static_cast<unsigned char>(bytes[i]);
  return value;
}

// What is wrong with a PNG's chunks, empty when nothing is: OpenCV decodes truncated files to partly grey
// images, and libpng says what it finds wrong on stderr.
std::string png_damage(std::string_view bytes) {
  for (std::size_t at = kPngSignature; at + kChunkFrame <= bytes.size();) {
    const std::size_t size = big_endian(bytes.substr(at));
    if (size > bytes.size() - at - kChunkFrame) break;
    const std::string_view checked = bytes.substr(at + 4, size + 4);
    if (libdeflate_crc32(0, checked.data(), checked.size()) != big_endian(bytes.substr(at + 8 + size)))
      return "is a damaged image";
    if (checked.starts_with("IEND")) return "";
    at += size + kChunkFrame;
  }
  return "is a truncated image";
}

std::string damage(std::string_view bytes) {
  if (bytes.starts_with("\x89PNG")) return png_damage(bytes);
  const bool is_jpeg = bytes.starts_with("\xff\xd8");
  if (is_jpeg && bytes.find("\xff\xd9", bytes.size() > 64 ? bytes.size() - 64 : 0) == bytes.npos)
    return "is a truncated image";
  return "";
}

}  // namespace

cv::Mat read_image(const std::filesystem::path& path) {
  return decode_image(read_text(path), kMostImageSide_px, path);
}

cv::Mat decode_image(std::string_view bytes, int most_side_px, const std::filesystem::path& path) {
  if (bytes.empty()) throw InputError(path, "is empty");
  if (bytes.size() > kMostImageBytes) throw InputError(path, "is longer than an image");
  check_image_size(bytes, most_side_px, path);
  if (const std::string what = damage(bytes); !what.empty()) throw InputError(path, what);
  cv::Mat image;
  try {
    const cv::Mat buffer(1, static_cast<int>(bytes.size()), CV_8UC1, const_cast<char*>(bytes.data()));
    image = cv::imdecode(buffer, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception&) {
  }
  if (image.empty()) throw InputError(path, "is not an image that can be decoded");
  return image;
}

void write_png(const std::filesystem::path& path, const cv::Mat& image) {
  std::vector<unsigned char> bytes;
  if (!cv::imencode(".png", image, bytes,
                    {cv::IMWRITE_PNG_COMPRESSION, 1}))  // level 1: 30 times faster than 9
    throw std::runtime_error(fmt::format("{}: cannot be encoded", path.string()));
  write_text(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

}  // namespace uniquadric
