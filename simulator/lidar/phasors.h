#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace uniquadric {

/// exp(2 pi i hz t) of beam after beam, t = (index + shift) / rate: the angle is computed afresh every
/// kStride beams and advanced from there by a table, so that a value depends on its index alone.
class Phasors {
 public:
  Phasors(double hz, double rate_hz, double shift, double phase_rad)
      : turns_a_stride_(hz * kStride / rate_hz) {
    for (int i = 0; i < kStride; ++i) {
      const double angle = phase_rad + 2 * std::numbers::pi * hz * (i + shift) / rate_hz;
      cos_[i] = std::cos(angle);
      sin_[i] = std::sin(angle);
    }
  }

  /// Writes `count` cosines and sines from beam `first` on.
  void fill(std::int64_t first, int count, double* cosine, double* sine) const {
    for (int done = 0; done < count;) {
      const std::int64_t stride = (first + done) / kStride;
      const int from = static_cast<int>((first + done) % kStride);
      const int n = std::min(kStride - from, count - done);
      const double turns = turns_a_stride_ * static_cast<double>(stride);
      const double angle = 2 * std::numbers::pi * (turns - std::round(turns));
      const double c = std::cos(angle), s = std::sin(angle);
      for (int i = 0; i < n; ++i) {
        cosine[done + i] = c * cos_[from + i] - s * sin_[from + i];
        sine[done + i] = s * cos_[from + i] + c * sin_[from + i];
      }
      done += n;
    }
  }

 private:
  static constexpr int kStride = 64;
  double turns_a_stride_;
  std::array<double, kStride> cos_, sin_;
};

}  // namespace uniquadric
