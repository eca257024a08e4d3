#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "simulator/scene/scene.h"

namespace uniquadric {

/// Adds white Gaussian noise to colour images, rounded to whole grey levels and cut off at 0 and 255. Its
/// numbers depend on (seed, frame, row) and the place in the row alone.
class ImageNoiseSource {
 public:
  ImageNoiseSource(const ImageNoise& noise, std::uint64_t seed);

  /// Adds the noise of one row to its values, pixel by pixel, channel by channel.
  void add_to_row(std::int64_t frame, int row, std::span<std::uint8_t> values);

 private:
  std::uint64_t seed_;
  std::vector<std::int16_t> levels_;  ///< the distribution of the rounded noise; empty: no noise
  std::vector<std::uint32_t> bits_;   ///< reused
  std::vector<std::int16_t> row_;     ///< reused
};

}  // namespace uniquadric
