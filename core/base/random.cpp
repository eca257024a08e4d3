#include "core/base/random.h"

#include <cmath>
#include <numbers>

#include "core/base/hash.h"
#include "core/base/philox.h"

namespace uniquadric {

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
  for (; i + 4 * kPhiloxLanes <= values.size(); i += 4 * kPhiloxLanes) {
    philox_lanes(counter_, key_, &values[i]);
    counter_[0] += kPhiloxLanes;
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
