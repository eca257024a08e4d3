#include "simulator/lidar/scan_pattern.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/base/error.h"
#include "simulator/lidar/pattern_source.h"

namespace uniquadric {

namespace {
// Times are not negative, and this is a tenth of std::llround's cost.
std::int64_t rounded(double time_ns) {
  return static_cast<std::int64_t>(time_ns + 0.5);
}
}  // namespace

std::int64_t FiringTimes::at(std::int64_t index) const {
  const auto n = static_cast<std::int64_t>(offsets_ns.size());
  return rounded(static_cast<double>(index / n) * cycle_ns + offsets_ns[static_cast<std::size_t>(index % n)]);
}

void FiringTimes::fill(std::int64_t first, int count, std::int64_t* times_ns) const {
  const auto n = static_cast<std::int64_t>(offsets_ns.size());
  auto place = static_cast<std::size_t>(first % n);
  double cycle = static_cast<double>(first / n);
  for (int i = 0; i < count; ++i) {
    times_ns[i] = rounded(cycle * cycle_ns + offsets_ns[place]);
    if (++place < offsets_ns.size()) continue;
    place = 0;
    ++cycle;
  }
}

std::int64_t FiringTimes::first_at(std::int64_t time_ns) const {
  const auto n = static_cast<std::int64_t>(offsets_ns.size());
  const auto whole = static_cast<std::int64_t>(std::floor(static_cast<double>(time_ns) / cycle_ns));
  // The times are rounded, so the beam may lie in a cycle beside the one that division names.
  std::int64_t low = std::max<std::int64_t>(0, (whole - 1) * n),
               high = std::max<std::int64_t>(0, (whole + 2) * n);
  while (low < high) {
    const std::int64_t middle = low + (high - low) / 2;
    if (at(middle) < time_ns)
      low = middle + 1;
    else
      high = middle;
  }
  return low;
}

ScanPattern::ScanPattern(std::shared_ptr<const Source> source) : source_(std::move(source)) {}

std::int64_t ScanPattern::first_at(std::int64_t time_ns) const {
  return source_->times.first_at(time_ns);
}

void ScanPattern::fill(std::int64_t first, int count, BeamBlock& block) const {
  assert(first >= 0 && count >= 0 && count <= BeamBlock::kCapacity);
  block.count = count;
  source_->times.fill(first, count, block.time_ns.data());
  source_->fill(first, count, block);
}

double ScanPattern::beams_per_s() const {
  return static_cast<double>(source_->times.offsets_ns.size()) / source_->times.cycle_ns * 1e9;
}

int ScanPattern::rings() const {
  return source_->rings;
}

ScanPattern named_pattern(std::string_view name, double spin_hz) {
  if (auto source = livox_source(name)) return ScanPattern(source);
  if (auto source = spinning_source(name, spin_hz)) return ScanPattern(source);
  throw InputError(
      fmt::format("'{}' is no scan pattern; there are: {}", name, fmt::join(kPatternNames, ", ")));
}

}  // namespace uniquadric
