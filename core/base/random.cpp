#include "core/base/random.h"

#include <cmath>
#include <numbers>
#if defined(__SSE2__)
#include <emmintrin.h>
#endif

#include "core/base/hash.h"

namespace uniquadric {
namespace {

std::array<std::uint32_t, 4> philox(std::array<std::uint32_t, 4> counter, std::array<std::uint32_t, 2> key) {
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t p0 = std::uint64_t{0xD2511F53u} * counter[0];
    const std::uint64_t p1 = std::uint64_t{0xCD9E8D57u} * counter[2];
    counter = {static_cast<std::uint32_t>(p1 >> 32) ^ counter[1] ^ key[0], static_cast<std::uint32_t>(p1),
               static_cast<std::uint32_t>(p0 >> 32) ^ counter[3] ^ key[1], static_cast<std::uint32_t>(p0)};
    key[0] += 0x9E3779B9u;
    key[1] += 0xBB67AE85u;
  }
  return counter;
}

constexpr std::size_t kLanes = 8;

// kLanes successive blocks at once: the same numbers as philox() gives, block after block.
#if defined(__SSE2__)
// Two blocks a vector, each word in the low half of 64 bits as the multiplication wants it; what stands in
// the high halves never reaches a low one. Twice as fast as what the compiler makes of a loop.
struct PhiloxPair {
  __m128i c0, c1, c2, c3;
};

__m128i twice(std::uint32_t value) {
  return _mm_set1_epi64x(value);
}

PhiloxPair philox_round(const PhiloxPair& c, __m128i key0, __m128i key1) {
  const __m128i p0 = _mm_mul_epu32(c.c0, twice(0xD2511F53u)), p1 = _mm_mul_epu32(c.c2, twice(0xCD9E8D57u));
  return {_mm_xor_si128(_mm_xor_si128(_mm_srli_epi64(p1, 32), c.c1), key0), p1,
          _mm_xor_si128(_mm_xor_si128(_mm_srli_epi64(p0, 32), c.c3), key1), p0};
}

void store(const PhiloxPair& c, std::uint32_t* values) {
  const __m128i low = twice(0xffffffffu);
  const __m128i c01 = _mm_or_si128(_mm_and_si128(c.c0, low), _mm_slli_epi64(c.c1, 32));
  const __m128i c23 = _mm_or_si128(_mm_and_si128(c.c2, low), _mm_slli_epi64(c.c3, 32));
  _mm_storeu_si128(reinterpret_cast<__m128i*>(values), _mm_unpacklo_epi64(c01, c23));
  _mm_storeu_si128(reinterpret_cast<__m128i*>(values + 4), _mm_unpackhi_epi64(c01, c23));
}

void philox_lanes(const std::array<std::uint32_t, 4>& counter, std::array<std::uint32_t, 2> key,
                  std::uint32_t* values) {
  std::array<PhiloxPair, kLanes / 2> pairs;
  for (std::uint32_t i = 0; i < pairs.size(); ++i)
    pairs[i] = {_mm_set_epi64x(std::uint32_t{counter[0] + 2 * i + 1}, std::uint32_t{counter[0] + 2 * i}),
                twice(counter[1]), twice(counter[2]), twice(counter[3])};
  for (int round = 0; round < 10; ++round) {
    const __m128i key0 = twice(key[0]), key1 = twice(key[1]);
    for (PhiloxPair& pair : pairs) pair = philox_round(pair, key0, key1);
    key[0] += 0x9E3779B9u;
    key[1] += 0xBB67AE85u;
  }
  for (std::size_t i = 0; i < pairs.size(); ++i) store(pairs[i], values + 8 * i);
}
#else
void philox_lanes(std::array<std::uint32_t, 4> counter, const std::array<std::uint32_t, 2>& key,
                  std::uint32_t* values) {
  for (std::size_t i = 0; i < kLanes; ++i, ++counter[0])
    for (const std::uint32_t word : philox(counter, key)) *values++ = word;
}
#endif

}  // namespace

RandomStream::RandomStream(std::uint64_t seed, std::string_view name, std::uint64_t frame,
                           std::uint32_t element) {
  Hash hash;
  hash.add(seed).add(name);
  const std::uint64_t key = hash.value();
  key_ = {static_cast<std::uint32_t>(key), static_cast<std::uint32_t>(key >> 32)};
  counter_ = {0, element, static_cast<std::uint32_t>(frame), static_cast<std::uint32_t>(frame >> 32)};
}

RandomStream RandomStream::at_element(std::uint32_t element) const {
  RandomStream stream = *this;
  stream.counter_[0] = 0;
  stream.counter_[1] = element;
  stream.used_ = 4;
  stream.has_spare_ = false;
  return stream;
}

std::uint32_t RandomStream::bits() {
  if (used_ == 4) {
    block_ = philox(counter_, key_);
    ++counter_[0];
    used_ = 0;
  }
  return block_[used_++];
}

void RandomStream::fill(std::span<std::uint32_t> values) {
  std::size_t i = 0;
  while (i < values.size() && used_ < 4) values[i++] = block_[used_++];
  for (; i + 4 * kLanes <= values.size(); i += 4 * kLanes) {
    philox_lanes(counter_, key_, &values[i]);
    counter_[0] += kLanes;
  }
  while (i < values.size()) values[i++] = bits();
}

double RandomStream::uniform() {
  return (bits() + 0.5) * 0x1p-32;
}

double RandomStream::normal() {
  if (has_spare_) {
    has_spare_ = false;
    return spare_normal_;
  }
  const double radius = std::sqrt(-2 * std::log(uniform()));
  const double angle = 2 * std::numbers::pi * uniform();
  spare_normal_ = radius * std::sin(angle);
  has_spare_ = true;
  return radius * std::cos(angle);
}

std::uint32_t RandomStream::below(std::uint32_t n) {
  return static_cast<std::uint32_t>((std::uint64_t{bits()} * n) >> 32);
}

}  // namespace uniquadric
