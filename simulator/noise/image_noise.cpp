#include "simulator/noise/image_noise.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/random.h"
#include "simulator/noise/normals.h"

namespace uniquadric {
namespace {

constexpr int kTableSize = 1 << 16;  // entries: each stands for a probability of 1.5e-5

// The distribution of the rounded noise as a table: an entry drawn uniformly is a draw of the noise. Pixels
// are whole numbers before, so that rounding the noise rounds the sum.
std::vector<std::int16_t> make_table(double sigma) {
  std::vector<std::int16_t> table(kTableSize);
  const int reach = static_cast<int>(std::ceil(5 * sigma)) + 1;  // beyond 5 sigma no entry is left
  int begin = 0;
  for (int level = -reach; level <= reach; ++level) {
    const double up_to = level == reach ? 1 : normal_cdf((level + 0.5) / sigma);
    const int end = static_cast<int>(std::lround(up_to * kTableSize));
    std::fill(table.begin() + begin, table.begin() + end, static_cast<std::int16_t>(level));
    begin = end;
  }
  return table;
}

std::uint8_t add(std::uint8_t pixel, int noise) {
  return static_cast<std::uint8_t>(std::clamp(pixel + noise, 0, 255));
}

}  // namespace

cv::Mat add_image_noise(const cv::Mat& rgb, const ImageNoise& noise, std::uint64_t seed, std::int64_t frame) {
  cv::Mat noisy = rgb.clone();
  if (noise.sigma <= 0) return noisy;
  const std::vector<std::int16_t> table = make_table(noise.sigma);
  const int values = noisy.cols * noisy.channels();
  std::vector<std::uint32_t> bits(static_cast<std::size_t>(values + 1) / 2);  // 32 bits are two draws
  for (int v = 0; v < noisy.rows; ++v) {
    RandomStream stream(seed, "image_noise", static_cast<std::uint64_t>(frame),
                        static_cast<std::uint32_t>(v));
    auto* row = noisy.ptr<std::uint8_t>(v);
    stream.fill(bits);
    for (int i = 0; i + 1 < values; i += 2) {
      row[i] = add(row[i], table[bits[i / 2] & 0xffff]);
      row[i + 1] = add(row[i + 1], table[bits[i / 2] >> 16]);
    }
    if (values % 2) row[values - 1] = add(row[values - 1], table[bits.back() & 0xffff]);
  }
  return noisy;
}

}  // namespace uniquadric
