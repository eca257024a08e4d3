#pragma once

#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include "simulator/lidar/scan_pattern.h"

namespace uniquadric {

/// When beams are fired: `offsets_ns` (not decreasing, within a cycle) repeated every `cycle_ns`.
struct FiringTimes {
  double cycle_ns = 0;
  std::vector<double> offsets_ns;

  std::int64_t at(std::int64_t index) const;  ///< [ns], rounded
  void fill(std::int64_t first, int count, std::int64_t* times_ns) const;
  std::int64_t first_at(std::int64_t time_ns) const;
};

/// What a pattern evaluates. A beam's values depend on its index alone, not on the block it is asked for in.
class ScanPattern::Source {
 public:
  Source(FiringTimes firing_times, int ring_count) : times(std::move(firing_times)), rings(ring_count) {}
  virtual ~Source() = default;
  /// Fills directions, origins and rings; times are filled by the caller.
  virtual void fill(std::int64_t first, int count, BeamBlock& block) const = 0;

  const FiringTimes times;
  const int rings;
};

std::shared_ptr<const ScanPattern::Source> livox_source(std::string_view name);
std::shared_ptr<const ScanPattern::Source> spinning_source(std::string_view name, double spin_hz);

}  // namespace uniquadric
