#include "core/base/random.h"

#include <cmath>
#include <numbers>

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

// kLanes successive blocks at once, side by side so that the compiler computes them with vector instructions.
void philox_lanes(const std::array<std::uint32_t, 4>& counter, std::array<std::uint32_t, 2> key,
                  std::uint32_t* values) {
  std::array<std::uint32_t, kLanes> c0, c1, c2, c3;
  for (std::uint32_t i = 0; i < kLanes; ++i) c0[i] = counter[0] + i;
  c1.fill(counter[1]), c2.fill(counter[2]), c3.fill(counter[3]);
  for (int round = 0; round < 10; ++round) {
    for (std::size_t i = 0; i < kLanes; ++i) {
      const std::uint64_t p0 = std::uint64_t{0xD2511F53u} * c0[i];
      const std::uint64_t p1 = std::uint64_t{0xCD9E8D57u} * c2[i];
      c0[i] = static_cast<std::uint32_t>(p1 >> 32) ^ c1[i] ^ key[0];
      c2[i] = static_cast<std::uint32_t>(p0 >> 32) ^ c3[i] ^ key[1];
      c1[i] = static_cast<std::uint32_t>(p1);
      c3[i] = static_cast<std::uint32_t>(p0);
    }
    key[0] += 0x9E3779B9u;
    key[1] += 0xBB67AE85u;
  }
  for (std::size_t i = 0; i < kLanes; ++i) {
    values[4 * i] = c0[i], values[4 * i + 1] = c1[i];
    values[4 * i + 2] = c2[i], values[4 * i + 3] = c3[i];
  }
}

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
