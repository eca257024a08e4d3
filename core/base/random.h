#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

namespace uniquadric {

/// A counter-based random stream (Philox4x32-10: Salmon et al., "Parallel random numbers: as easy as 1, 2,
/// 3", SC 2011). Its numbers depend on (seed, name, frame, element) alone, so any thread may draw them in any
/// order of frames and the result is the same bytes.
class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::string_view name, std::uint64_t frame = 0, std::uint32_t element = 0);

  /// The start of the stream of another element of the same seed, name and frame.
  RandomStream at_element(std::uint32_t element) const;

  /// 32 uniform random bits.
  std::uint32_t bits();
  /// The same numbers as that many calls of bits(), some four times faster.
  void fill(std::span<std::uint32_t> values);
  /// Uniform in (0, 1): neither end is ever drawn, so its logarithm is finite.
  double uniform();
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// Standard normal (Box-Muller).
  double normal();
  /// Uniform in {0, ..., n-1}; n > 0.
  std::uint32_t below(std::uint32_t n);

 private:
  std::array<std::uint32_t, 2> key_;
  std::array<std::uint32_t, 4> counter_;
  std::array<std::uint32_t, 4> block_{};
  int used_ = 4;  // of block_
  double spare_normal_ = 0;
  bool has_spare_ = false;
};

}  // namespace uniquadric
