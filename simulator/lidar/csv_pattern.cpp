#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "core/base/error.h"
#include "core/base/text.h"
#include "simulator/lidar/pattern_source.h"

namespace uniquadric {
namespace {

constexpr double kMostTime_s = 1e5;  // ours: a day of a pattern that does not repeat
constexpr double kLeastStep_ns = 1;  // ours: a gigahertz of beams, which no LiDAR has

struct Direction {
  double x, y, z;
};

class TablePattern : public ScanPattern::Source {
 public:
  TablePattern(FiringTimes firing_times, std::vector<Direction> directions)
      : Source(std::move(firing_times), 1), directions_(std::move(directions)) {}

  void fill(std::int64_t first, int count, BeamBlock& block) const override {
    const auto n = static_cast<std::int64_t>(directions_.size());
    for (int i = 0; i < count; ++i) {
      const Direction& d = directions_[static_cast<std::size_t>((first + i) % n)];
      block.x[i] = d.x;
      block.y[i] = d.y;
      block.z[i] = d.z;
      block.origin_x[i] = block.origin_y[i] = block.origin_z[i] = 0;
      block.ring[i] = 0;
    }
  }

 private:
  std::vector<Direction> directions_;
};

struct TableReader {
  const std::filesystem::path& path;
  FiringTimes times;
  std::vector<Direction> directions;
  bool has_header = false;

  void read_line(int line, const std::vector<std::string_view>& fields) {
    constexpr std::array<std::string_view, 3> kHeader = {"Time/s", "Azimuth/deg", "Zenith/deg"};
    if (fields.size() != kHeader.size())
      throw InputError(path, line, fmt::format("expected 3 columns, found {}", fields.size()));
    if (!has_header) {
      for (std::size_t k = 0; k < kHeader.size(); ++k)
        if (fields[k] != kHeader[k])
          throw InputError(path, line,
                           fmt::format("column {} is '{}', expected '{}'", k + 1, fields[k], kHeader[k]));
      has_header = true;
      return;
    }
    std::array<double, 3> values{};
    for (std::size_t k = 0; k < values.size(); ++k) {
      const auto value = parse_double(fields[k]);
      if (!value)
        throw InputError(path, line, fmt::format("{}: '{}' is no finite number", kHeader[k], fields[k]));
      values[k] = *value;
    }
    add(line, values);
  }

  void add(int line, const std::array<double, 3>& values) {
    const double time_ns = values[0] * 1e9;
    if (time_ns < 0) throw InputError(path, line, fmt::format("time {} s is before 0", values[0]));
    if (values[0] > kMostTime_s)
      throw InputError(path, line, fmt::format("time {} s is beyond {} s", values[0], kMostTime_s));
    if (!times.offsets_ns.empty() && time_ns <= times.offsets_ns.back())
      throw InputError(path, line, fmt::format("time {} s does not follow the line before", values[0]));
    if (values[2] < 0 || values[2] > 180)
      throw InputError(path, line, fmt::format("zenith {} deg is outside 0..180", values[2]));
    constexpr double kDegree = std::numbers::pi / 180;
    const double azimuth = values[1] * kDegree, zenith = values[2] * kDegree;
    times.offsets_ns.push_back(time_ns);
    directions.push_back(
        {std::sin(zenith) * std::cos(azimuth), std::sin(zenith) * std::sin(azimuth), std::cos(zenith)});
  }
};

}  // namespace

ScanPattern csv_pattern(const std::filesystem::path& path) {
  TableReader reader{path, {}, {}};
  for_each_line(
      path, [&](int line, const auto& fields) { reader.read_line(line, fields); }, ',');
  auto& offsets = reader.times.offsets_ns;
  if (offsets.size() < 2)
    throw InputError(path, fmt::format("has {} beams, expected at least 2", offsets.size()));
  const double span = offsets.back() - offsets.front();
  reader.times.cycle_ns = span + span / static_cast<double>(offsets.size() - 1);
  if (!(reader.times.cycle_ns >= kLeastStep_ns * static_cast<double>(offsets.size())))
    throw InputError(path, fmt::format("has more than a beam in {} ns", kLeastStep_ns));
  const double start = offsets.front();
  // A table that starts beyond its own length would leave cycles without a beam at their place.
  if (start >= reader.times.cycle_ns) throw InputError(path, "the first time lies beyond the table's length");
  return ScanPattern(std::make_shared<TablePattern>(std::move(reader.times), std::move(reader.directions)));
}

}  // namespace uniquadric
