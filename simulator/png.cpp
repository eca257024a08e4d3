#include "simulator/png.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <libdeflate.h>
#include <unistd.h>

#include <cassert>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <vector>

#include "core/base/files.h"
#include "simulator/run_length_deflate.h"

namespace uniquadric {
namespace {

constexpr std::string_view kSignature = "\x89PNG\r\n\x1a\n";
constexpr char kFilterNone = 0, kFilterUp = 2;
constexpr std::size_t kLargestBlock = 65535, kBlockHeader = 5;  // RFC 1951, 3.2.4

std::string big_endian(std::uint32_t value) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift);
  return bytes;
}

std::uint32_t checksum(std::string_view type_and_data) {
  return libdeflate_crc32(0, type_and_data.data(), type_and_data.size());
}

std::string chunk(std::string_view type, std::string_view data) {
  const std::string content = std::string(type).append(data);
  return big_endian(static_cast<std::uint32_t>(data.size())) + content + big_endian(checksum(content));
}

std::string file_begin(PngFormat format, int width, int height) {
  const bool color = format == PngFormat::rgb_8;
  const std::string kind = {color ? '\x08' : '\x10', color ? '\x02' : '\0'};  // bits, colour type
  return std::string(kSignature) +
         chunk("IHDR", big_endian(static_cast<std::uint32_t>(width)) +
                           big_endian(static_cast<std::uint32_t>(height)) + kind + std::string(3, '\0'));
}

// A block that is stored as it is: its size and that inverted, low byte first.
void put_block_header(char* out, bool last, std::size_t size) {
  const char low = static_cast<char>(size), high = static_cast<char>(size >> 8);
  const char header[kBlockHeader] = {last ? '\1' : '\0', low, high, static_cast<char>(~low),
                                     static_cast<char>(~high)};
  std::memcpy(out, header, kBlockHeader);
}

}  // namespace

StoredPng::StoredPng(PngFormat format, int width, int height)
    : row_size_(1 + (format == PngFormat::rgb_8 ? 3u : 2u) * static_cast<std::size_t>(width)),
      rows_a_block_(kLargestBlock / row_size_),
      rows_(static_cast<std::size_t>(height)),
      bytes_(file_begin(format, width, height)) {
  assert(rows_a_block_ > 0);
  const std::size_t blocks = (rows_ + rows_a_block_ - 1) / rows_a_block_;
  const std::size_t data_size = 2 + blocks * kBlockHeader + rows_ * row_size_ + 4;
  bytes_ += big_endian(static_cast<std::uint32_t>(data_size)) + "IDAT\x78\x01";
  data_begin_ = bytes_.size();
  bytes_.resize(data_begin_ + data_size - 2 + 4);
  for (std::size_t first = 0; first < rows_; first += rows_a_block_) {
    const std::size_t rows = std::min(rows_a_block_, rows_ - first);
    put_block_header(reinterpret_cast<char*>(row(static_cast<int>(first))) - 1 - kBlockHeader,
                     first + rows == rows_, rows * row_size_);
  }
  for (std::size_t v = 0; v < rows_; ++v) row(static_cast<int>(v))[-1] = kFilterNone;
  bytes_ += chunk("IEND", "");
}

unsigned char* StoredPng::row(int v) {
  const auto place = static_cast<std::size_t>(v);
  return reinterpret_cast<unsigned char*>(bytes_.data()) + data_begin_ +
         (place / rows_a_block_ + 1) * kBlockHeader + place * row_size_ + 1;
}

std::string_view StoredPng::finish() {
  std::uint32_t sum = 1;
  for (std::size_t first = 0; first < rows_; first += rows_a_block_)
    sum = libdeflate_adler32(sum, row(static_cast<int>(first)) - 1,
                             std::min(rows_a_block_, rows_ - first) * row_size_);
  const std::size_t end = static_cast<std::size_t>(row(static_cast<int>(rows_) - 1) -
                                                   reinterpret_cast<unsigned char*>(bytes_.data())) +
                          row_size_ - 1;
  bytes_.replace(end, 4, big_endian(sum));
  const std::size_t begin = data_begin_ - 2 - 4;  // of "IDAT"
  bytes_.replace(end + 4, 4, big_endian(checksum(std::string_view(bytes_).substr(begin, end + 4 - begin))));
  return bytes_;
}

std::string pack_png(const cv::Mat& ids) {
  assert(ids.type() == CV_16UC1);
  const auto row_size = 2 * static_cast<std::size_t>(ids.cols);
  std::vector<unsigned char> filtered((row_size + 1) * static_cast<std::size_t>(ids.rows));
  const std::vector<std::uint16_t> nothing(static_cast<std::size_t>(ids.cols));
  const std::uint16_t* above = nothing.data();
  unsigned char* out = filtered.data();
  for (int v = 0; v < ids.rows; ++v, out += row_size) {
    const auto* row = ids.ptr<std::uint16_t>(v);
    *out++ = kFilterUp;
    const bool repeated = std::memcmp(row, above, row_size) == 0;  // the difference: zeros, as there are
    for (int u = 0; u < ids.cols && !repeated; ++u) {
      out[2 * u] = static_cast<unsigned char>((row[u] >> 8) - (above[u] >> 8));
      out[2 * u + 1] = static_cast<unsigned char>(row[u] - above[u]);
    }
    above = row;
  }
  return file_begin(PngFormat::grey_16, ids.cols, ids.rows) + chunk("IDAT", deflate_runs(filtered)) +
         chunk("IEND", "");
}

void write_file(const std::filesystem::path& path, std::string_view bytes) {
  const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  bool good = file >= 0;
  while (good && !bytes.empty()) {
    const ssize_t written = write(file, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    good = written > 0;
    if (good) bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  const int error = errno;
  if (file >= 0 && close(file) != 0 && good) throw_unwritable(path);
  if (good) return;
  errno = error;
  throw_unwritable(path);
}

}  // namespace uniquadric
