#include "simulator/noise/image_noise.h"

#include <algorithm>
#include <cmath>

#include "core/base/random.h"
#include "core/base/vector_clones.h"
#include "simulator/noise/normals.h"

namespace uniquadric {
namespace {

constexpr int kTableSize = 1 << 16;  // entries: each stands for a probability of 1.5e-5

// The distribution of the rounded noise as a table: an entry drawn uniformly is a draw of the noise. Pixels
// are whole numbers before, so that rounding the noise rounds the sum.
std::vector<std::int16_t> make_levels(double sigma) {
  std::vector<std::int16_t> levels(kTableSize);
  const int reach = static_cast<int>(std::ceil(5 * sigma)) + 1;  // beyond 5 sigma no entry is left
  int begin = 0;
  for (int level = -reach; level <= reach; ++level) {
    const double up_to = level == reach ? 1 : normal_cdf((level + 0.5) / sigma);
    const int end = static_cast<int>(std::lround(up_to * kTableSize));
    std::fill(levels.begin() + begin, levels.begin() + end, static_cast<std::int16_t>(level));
    begin = end;
  }
  return levels;
}

// Apart from the drawing, so that the compiler adds eight values at once.
UNIQUADRIC_VECTOR_CLONES
void add_clamped(std::span<const std::int16_t> noise, std::span<std::uint8_t> values) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto sum = static_cast<std::int16_t>(values[i] + noise[i]);
    values[i] = static_cast<std::uint8_t>(std::clamp<std::int16_t>(sum, 0, 255));
  }
}

// Noise of a sigma for each value.
UNIQUADRIC_VECTOR_CLONES
void add_scaled(const float* __restrict normals, const float* __restrict sigmas, std::size_t count,
                std::uint8_t* __restrict values) {
  for (std::size_t i = 0; i < count; ++i) {
    const float noisy = static_cast<float>(values[i]) + sigmas[values[i]] * normals[i];
    const float above = noisy > 0 ? noisy : 0, clamped = above < 255 ? above : 255;
    values[i] = static_cast<std::uint8_t>(static_cast<int>(clamped + 0.5f));  // cut off is rounded
  }
}

}  // namespace

ImageNoiseSource::ImageNoiseSource(const ImageNoise& noise, std::uint64_t seed) : seed_(seed) {
  constexpr double kMost = 6000;  // grey levels: any picture is gone long before, and 16 bits hold five sigma
  const double sigma = std::min(noise.sigma, kMost);
  if (noise.electrons_per_level > 0)
    for (int value = 0; value < 256; ++value)
      sigmas_.push_back(static_cast<float>(std::sqrt(sigma * sigma + value / noise.electrons_per_level)));
  else if (sigma > 0)
    levels_ = make_levels(sigma);
}

void ImageNoiseSource::add_to_row(std::int64_t frame, int row, std::span<std::uint8_t> values) {
  RandomStream stream(seed_, "image_noise", static_cast<std::uint64_t>(frame),
                      static_cast<std::uint32_t>(row));
  if (!sigmas_.empty())
    add_by_value(stream, values);
  else if (!levels_.empty())
    add_by_level(stream, values);
}

void ImageNoiseSource::add_by_level(RandomStream& stream, std::span<std::uint8_t> values) {
  const std::size_t words = (values.size() + 1) / 2;  // 32 bits are two draws
  bits_.resize(words);
  row_.resize(2 * words);
  stream.fill(bits_);
  const std::int16_t* levels = levels_.data();
  for (std::size_t i = 0; i < words; ++i) {
    row_[2 * i] = levels[bits_[i] & 0xffff];
    row_[2 * i + 1] = levels[bits_[i] >> 16];
  }
  add_clamped(row_, values);
}

void ImageNoiseSource::add_by_value(RandomStream& stream, std::span<std::uint8_t> values) {
  normals_.resize(values.size());
  fill_normals(stream, normals_);
  add_scaled(normals_.data(), sigmas_.data(), values.size(), values.data());
}

}  // namespace uniquadric
