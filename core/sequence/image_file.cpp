#include "core/sequence/image_file.h"

#include <fmt/format.h>
#include <libdeflate.h>

#include <cstdint>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <stdexcept>

#include "core/base/error.h"
#include "core/base/on_demand.h"

namespace uniquadric {
namespace {

constexpr std::size_t kMostImageBytes = 1 << 30;
constexpr std::size_t kChunkFrame = 12;  // bytes: length, type, checksum
// Whole, as OpenCV has them: what begins otherwise goes to the first of its dozens of readers that likes the
// rest, of which that of DICOM takes 2 GB if a file of 1 kB says so, or ends the program by an assertion.
constexpr std::string_view kPngSignature = "\x89PNG\r\n\x1a\n", kJpegSignature = "\xff\xd8\xff";

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

// Throws for more than `most_side_px` pixels a side: decoded, a few kilobytes can fill the memory.
void check_image_size(std::string_view bytes, int most_side_px, const std::filesystem::path& path) {
  const bool is_png = bytes.starts_with(kPngSignature), is_jpeg = bytes.starts_with(kJpegSignature);
  if (!is_png && !is_jpeg)
    throw InputError(path, "is not an image that can be decoded: neither PNG nor JPEG");
  const auto size = is_png ? png_size(bytes) : jpeg_size(bytes);
  if (!size) throw InputError(path, "is not an image that can be decoded: no size");
  if (size->width > most_side_px || size->height > most_side_px)
    throw InputError(path, fmt::format("has {:.0f}x{:.0f} px, at most {} a side are read", size->width,
                                       size->height, most_side_px));
}

// What is wrong with a PNG's chunks, empty when nothing is: OpenCV decodes truncated files to partly grey
// images, and libpng says what it finds wrong on stderr.
std::string png_damage(std::string_view bytes) {
  for (std::size_t at = kPngSignature.size(); at + kChunkFrame <= bytes.size();) {
    const std::size_t size = big_endian(bytes, at, 4);
    if (size > bytes.size() - at - kChunkFrame) break;
    const std::string_view checked = bytes.substr(at + 4, size + 4);
    if (libdeflate_crc32(0, checked.data(), checked.size()) != big_endian(bytes, at + 8 + size, 4))
      return "is a damaged image";
    if (checked.starts_with("IEND")) return "";
    at += size + kChunkFrame;
  }
  return "is a truncated image";
}

std::string damage(std::string_view bytes) {
  if (bytes.starts_with(kPngSignature)) return png_damage(bytes);
  return bytes.starts_with(kJpegSignature) && !is_whole_jpeg(bytes) ? "is a truncated image" : "";
}

}  // namespace

bool is_whole_jpeg(std::string_view bytes) {
  return bytes.starts_with(kJpegSignature) &&
         bytes.find("\xff\xd9", bytes.size() > 64 ? bytes.size() - 64 : 0) != bytes.npos;
}

cv::Mat decode_image(std::string_view bytes, int most_side_px, const std::filesystem::path& path) {
  if (bytes.empty()) throw InputError(path, "is empty");
  if (bytes.size() > kMostImageBytes) throw InputError(path, "is longer than an image");
  check_image_size(bytes, most_side_px, path);
  if (const std::string what = damage(bytes); !what.empty()) throw InputError(path, what);
  // OpenCV's readers link a hundred libraries, GDAL's among them, whose loading is most of a short command's
  // time. C++ names, as the linker has them.
  static const auto imdecode = function_on_demand<cv::Mat(cv::InputArray, int)>(
      UNIQUADRIC_IMGCODECS, "_ZN2cv8imdecodeERKNS_11_InputArrayEi");
  cv::Mat image;
  try {
    const cv::Mat buffer(1, static_cast<int>(bytes.size()), CV_8UC1, const_cast<char*>(bytes.data()));
    image = imdecode(buffer, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception&) {
  }
  if (image.empty()) throw InputError(path, "is not an image that can be decoded");
  return image;
}

std::string encode_image(const std::string& ending, const cv::Mat& image, const std::vector<int>& parameters,
                         const std::filesystem::path& path) {
  using Encode =
      bool(const std::string&, cv::InputArray, std::vector<unsigned char>&, const std::vector<int>&);
  static const auto imencode =
      function_on_demand<Encode>(UNIQUADRIC_IMGCODECS,
                                 "_ZN2cv8imencodeERKNSt7__cxx1112basic_stringIcSt11char_traitsIcESaIcEEERKNS_"
                                 "11_InputArrayERSt6vectorIhSaIhEE"
                                 "RKSB_IiSaIiEE");
  std::vector<unsigned char> bytes;
  bool encoded = false;
  try {
    encoded = imencode(ending, image, bytes, parameters);
  } catch (const cv::Exception&) {
  }
  if (!encoded) throw std::runtime_error(fmt::format("{}: cannot be encoded", path.string()));
  return {bytes.begin(), bytes.end()};
}

}  // namespace uniquadric
