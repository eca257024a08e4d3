#include "simulator/run_length_deflate.h"

#include <libdeflate.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>

namespace uniquadric {
namespace {

constexpr std::size_t kShortestMatch = 3, kLongestMatch = 258;

// Bits fill bytes from the lowest on.
class BitWriter {
 public:
  explicit BitWriter(std::string& out) : out_(out) {}
  void put(std::uint32_t bits, int count) {
    pending_ |= std::uint64_t{bits} << used_;
    for (used_ += count; used_ >= 8; used_ -= 8, pending_ >>= 8) out_ += static_cast<char>(pending_);
  }
  void flush() {
    if (used_ > 0) put(0, 8 - used_);
  }

 private:
  std::string& out_;
  std::uint64_t pending_ = 0;
  int used_ = 0;
};

// Huffman codes alone stand highest bit first.
void put_code(BitWriter& out, std::uint32_t code, int count) {
  std::uint32_t reversed = 0;
  for (int i = 0; i < count; ++i) reversed |= (code >> i & 1) << (count - 1 - i);
  out.put(reversed, count);
}

// RFC 1951, 3.2.6
void put_symbol(BitWriter& out, std::uint32_t symbol) {
  if (symbol < 144)
    put_code(out, 0x30 + symbol, 8);
  else if (symbol < 256)
    put_code(out, 0x190 + symbol - 144, 9);
  else if (symbol < 280)
    put_code(out, symbol - 256, 7);
  else
    put_code(out, 0xC0 + symbol - 280, 8);
}

// `length` times the byte before. RFC 1951, 3.2.5: four symbols to each number of extra bits.
void put_match(BitWriter& out, std::size_t length) {
  if (length == kLongestMatch) {
    put_symbol(out, 285);
  } else {
    const auto beyond = static_cast<std::uint32_t>(length - kShortestMatch);
    const int extra = std::max(0, static_cast<int>(std::bit_width(beyond)) - 3);
    put_symbol(out, 257 + 4 * static_cast<std::uint32_t>(extra) + (beyond >> extra));
    out.put(beyond & ((1u << extra) - 1), extra);
  }
  put_code(out, 0, 5);  // distance 1
}

void put_run(BitWriter& out, unsigned char byte, std::size_t length) {
  put_symbol(out, byte);
  for (--length; length >= kShortestMatch;) {
    const std::size_t match = std::min(length, kLongestMatch);
    put_match(out, match);
    length -= match;
  }
  for (; length > 0; --length) put_symbol(out, byte);
}

std::size_t run_length(const unsigned char* begin, const unsigned char* end) {
  const unsigned char* p = begin + 1;
  const std::uint64_t pattern = 0x0101010101010101u * *begin;
  for (std::uint64_t eight = 0; end - p >= 8; p += 8) {
    std::memcpy(&eight, p, 8);
    if (eight != pattern) break;
  }
  while (p < end && *p == *begin) ++p;
  return static_cast<std::size_t>(p - begin);
}

}  // namespace

std::string deflate_runs(std::span<const unsigned char> bytes) {
  std::string packed = "\x78\x01";
  packed.reserve(1 << 14);
  BitWriter out(packed);
  out.put(0b011, 3);  // last block, fixed codes
  for (std::size_t i = 0; i < bytes.size();) {
    const std::size_t length = run_length(&bytes[i], bytes.data() + bytes.size());
    put_run(out, bytes[i], length);
    i += length;
  }
  put_symbol(out, 256);
  out.flush();
  const std::uint32_t check = libdeflate_adler32(1, bytes.data(), bytes.size());
  for (int shift = 24; shift >= 0; shift -= 8) packed += static_cast<char>(check >> shift);
  return packed;
}

}  // namespace uniquadric
