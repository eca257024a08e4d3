#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace uniquadric {

/// Some beams in firing order, an array a component. Lidar frame: x forward, y left, z up.
struct BeamBlock {
  static constexpr int kCapacity = 256;
  template <typename T>
  using Row = std::array<T, kCapacity>;

  int count = 0;
  Row<std::int64_t> time_ns;                 ///< of firing, since the sensor's clock began
  Row<double> x, y, z;                       ///< unit direction
  Row<double> origin_x, origin_y, origin_z;  ///< where the beam starts [m]
  Row<std::uint16_t> ring;                   ///< number of the laser or line
};

/// Where a LiDAR points and when: an endless sequence of beams, each a function of its index alone.
class ScanPattern {
 public:
  class Source;
  explicit ScanPattern(std::shared_ptr<const Source> source);

  /// Index of the first beam fired at or after `time_ns` (at least 0): beams of a window are
  /// first_at(begin) .. first_at(end) - 1.
  std::int64_t first_at(std::int64_t time_ns) const;
  /// Fills `block` with the `count` (at most kCapacity) beams from index `first` on.
  void fill(std::int64_t first, int count, BeamBlock& block) const;
  double beams_per_s() const;
  int rings() const;

 private:
  std::shared_ptr<const Source> source_;
};

/// Names of the built-in patterns. livox_horizon and livox_mid360 are approximate (README).
inline constexpr std::array<std::string_view, 8> kPatternNames = {
    "livox_mid40", "livox_mid70", "livox_avia", "livox_horizon", "livox_mid360", "vlp16", "hdl64e", "os1_64"};

/// A built-in pattern. `spin_hz`: turns a second of the spinning sensors (vlp16, hdl64e, os1_64), which turn
/// clockwise seen from above and pass x at time 0; others have no such choice. Throws InputError for an
/// unknown name.
ScanPattern named_pattern(std::string_view name, double spin_hz = 10);

/// A pattern from a table with the header `Time/s,Azimuth/deg,Zenith/deg` (the layout of the makers' tables):
/// azimuth from x towards y, zenith angle from z; times must increase. It repeats, one mean step after its
/// last row. Throws InputError with file and line.
ScanPattern csv_pattern(const std::filesystem::path& path);

}  // namespace uniquadric
