#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/random.h"
#include "simulator/scene/scene.h"

namespace uniquadric {

/// Adds white Gaussian noise to colour images, rounded to whole grey levels and cut off at 0 and 255; with
/// shot noise its variance is that of `sigma` and value / electrons_per_level together (Poisson's for many
/// electrons). Its numbers depend on (seed, frame, row) and the place in the row alone.
class ImageNoiseSource {
 public:
  ImageNoiseSource(const ImageNoise& noise, std::uint64_t seed);

  /// Adds the noise of one row to its values, pixel by pixel, channel by channel.
  void add_to_row(std::int64_t frame, int row, std::span<std::uint8_t> values);

 private:
  void add_by_level(RandomStream& stream, std::span<std::uint8_t> values);
  void add_by_value(RandomStream& stream, std::span<std::uint8_t> values);

  std::uint64_t seed_;
  std::vector<std::int16_t> levels_;  ///< the distribution of the rounded noise, if it is one for all values
  std::vector<float> sigmas_;         ///< with shot noise: of each value
  std::vector<float> normals_;        ///< reused
  std::vector<std::uint32_t> bits_;   ///< reused
  std::vector<std::int16_t> row_;     ///< reused
};

}  // namespace uniquadric
