#include "simulator/png.h"

#include <libdeflate.h>

#include <cassert>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/files.h"

namespace uniquadric {
namespace {

using Bytes = std::vector<unsigned char>;

constexpr std::string_view kSignature = "\x89PNG\r\n\x1a\n";
constexpr unsigned char kFilterNone = 0, kFilterUp = 2;
constexpr int kLevel = 4;  // of libdeflate: measured fastest on masks filtered by rows

void append_u32(std::string& out, std::uint32_t value) {  // big-endian, as all of PNG
  for (int shift = 24; shift >= 0; shift -= 8) out += static_cast<char>(value >> shift);
}

void append_chunk(std::string& out, std::string_view type, std::string_view data) {
  append_u32(out, static_cast<std::uint32_t>(data.size()));
  const std::size_t begin = out.size();
  out.append(type).append(data);
  append_u32(out, libdeflate_crc32(0, out.data() + begin, out.size() - begin));
}

std::string header(const cv::Mat& image) {
  const bool color = image.type() == CV_8UC3;
  std::string data;
  append_u32(data, static_cast<std::uint32_t>(image.cols));
  append_u32(data, static_cast<std::uint32_t>(image.rows));
  data +=
      {color ? '\x08' : '\x10', color ? '\x02' : '\x00', '\0', '\0', '\0'};  // bits, colour type, defaults
  return data;
}

// A row's samples in PNG's order: red, green, blue; high byte first.
void pack_row(const cv::Mat& image, int v, unsigned char* out) {
  if (image.type() == CV_8UC3) {
    const auto* bgr = image.ptr<unsigned char>(v);
    for (int i = 0; i < 3 * image.cols; i += 3)
      out[i] = bgr[i + 2], out[i + 1] = bgr[i + 1], out[i + 2] = bgr[i];
  } else {
    const auto* values = image.ptr<std::uint16_t>(v);
    for (int u = 0; u < image.cols; ++u) {
      out[2 * u] = static_cast<unsigned char>(values[u] >> 8);
      out[2 * u + 1] = static_cast<unsigned char>(values[u]);
    }
  }
}

Bytes filter_rows(const cv::Mat& image, PngPacking packing) {
  const std::size_t row_size = image.elemSize() * static_cast<std::size_t>(image.cols);
  Bytes filtered((row_size + 1) * static_cast<std::size_t>(image.rows)), above(row_size), row(row_size);
  unsigned char* out = filtered.data();
  for (int v = 0; v < image.rows; ++v, out += row_size) {
    *out++ = packing == PngPacking::packed ? kFilterUp : kFilterNone;
    if (packing == PngPacking::stored) {
      pack_row(image, v, out);
      continue;
    }
    pack_row(image, v, row.data());
    for (std::size_t i = 0; i < row_size; ++i) out[i] = static_cast<unsigned char>(row[i] - above[i]);
    row.swap(above);
  }
  return filtered;
}

std::string deflate(const Bytes& bytes, int level) {
  const std::unique_ptr<libdeflate_compressor, void (*)(libdeflate_compressor*)> compressor(
      libdeflate_alloc_compressor(level), libdeflate_free_compressor);
  if (!compressor) throw std::bad_alloc();
  std::string packed(libdeflate_zlib_compress_bound(compressor.get(), bytes.size()), '\0');
  packed.resize(
      libdeflate_zlib_compress(compressor.get(), bytes.data(), bytes.size(), packed.data(), packed.size()));
  assert(!packed.empty());
  return packed;
}

}  // namespace

void write_png(const std::filesystem::path& path, const cv::Mat& image, PngPacking packing) {
  assert(image.type() == CV_8UC3 || image.type() == CV_16UC1);
  const std::string data = deflate(filter_rows(image, packing), packing == PngPacking::packed ? kLevel : 0);
  std::string file(kSignature);
  file.reserve(data.size() + 64);
  append_chunk(file, "IHDR", header(image));
  append_chunk(file, "IDAT", data);
  append_chunk(file, "IEND", "");
  write_text(path, file);
}

}  // namespace uniquadric
