#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <string_view>

#include "core/base/error.h"
#include "core/base/read_file.h"
#include "core/import/kitti_files.h"
#include "core/sequence/pcd.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr float kFullIntensity = 255;  // of a point; KITTI's reflectance is from 0 to 1
constexpr std::size_t kValues = 4;     // x y z reflectance
constexpr double kLongestScanS = 4;    // what 32 bits of nanoseconds hold
constexpr std::array<std::string_view, 4> kTimes = {"t", "offset_time", "time", "timestamp"};

std::vector<LidarPoint> read_bin(const fs::path& path, std::uint32_t end_ns) {
  const std::string bytes = read_file(path, kScanFile);
  constexpr std::size_t kPointSize = kValues * sizeof(float);
  if (bytes.size() % kPointSize != 0)
    throw InputError(path,
                     fmt::format("is {} bytes, no whole number of points of {}", bytes.size(), kPointSize));
  std::vector<LidarPoint> points;
  points.reserve(bytes.size() / kPointSize);
  for (std::size_t at = 0; at < bytes.size(); at += kPointSize) {
    float v[kValues];
    std::memcpy(v, bytes.data() + at, sizeof v);
    points.push_back({v[0], v[1], v[2], v[3] * kFullIntensity, end_ns});
  }
  return points;
}

std::string type_of(const PcdField& field) {
  return fmt::format("{}{}", field.type, field.size);
}

const PcdField* find_field(const PcdFile& file, std::string_view name) {
  const auto found =
      std::find_if(file.fields.begin(), file.fields.end(), [&](const PcdField& f) { return f.name == name; });
  return found == file.fields.end() ? nullptr : &*found;
}

// Empty returns and those that are no numbers may come without a time.
bool is_return(const LidarPoint& p) {
  return std::isfinite(p.x + p.y + p.z) && (p.x != 0 || p.y != 0 || p.z != 0);
}

// A timestamp may count from anywhere: its zero is the first point of the scan.
double zero_of(std::string_view name, const std::vector<double>& times_s,
               const std::vector<LidarPoint>& points) {
  if (name != "timestamp") return 0;
  double first_s = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < points.size(); ++i)
    if (is_return(points[i])) first_s = std::min(first_s, times_s[i]);
  return std::isfinite(first_s) ? first_s : 0;
}

void set_seconds(const fs::path& path, std::string_view name, const std::vector<double>& times_s,
                 std::vector<LidarPoint>& points) {
  const double zero_s = zero_of(name, times_s, points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double time_s = times_s[i] - zero_s;
    const bool is_in_scan = time_s >= 0 && time_s <= kLongestScanS;
    if (!is_in_scan && is_return(points[i]))
      throw InputError(path, fmt::format("point {}: {} {} is not within a scan", i, name, times_s[i]));
    points[i].offset_ns = is_in_scan ? static_cast<std::uint32_t>(std::llround(1e9 * time_s)) : 0;
  }
}

// The first field whose name and type are those of a time: whole nanoseconds, or seconds.
bool read_times(const fs::path& path, const PcdFile& file, std::vector<LidarPoint>& points) {
  for (const std::string_view name : kTimes) {
    const PcdField* field = find_field(file, name);
    if (!field) continue;
    const PcdColumn column = pcd_column(path, file, name, field->type, field->size);
    const std::string type = type_of(*field);
    if (type == "U4" && (name == "t" || name == "offset_time")) {
      for (std::int64_t i = 0; i < file.points; ++i) points[i].offset_ns = column.at<std::uint32_t>(i);
      return true;
    }
    if (type != "F4" && type != "F8") continue;
    std::vector<double> times_s;
    for (std::int64_t i = 0; i < file.points; ++i)
      times_s.push_back(type == "F4" ? double{column.at<float>(i)} : column.at<double>(i));
    set_seconds(path, name, times_s, points);
    return true;
  }
  return false;
}

// A value of one byte, or of `type` and `size`.
template <typename Wide, typename Set>
void read_column(const fs::path& path, const PcdFile& file, const char* name, char type, const Set& set) {
  const PcdField* field = find_field(file, name);
  if (!field) return;
  const bool is_byte = type_of(*field) == "U1";
  const PcdColumn column =
      is_byte ? pcd_column(path, file, name, 'U', 1) : pcd_column(path, file, name, type, sizeof(Wide));
  for (std::int64_t i = 0; i < file.points; ++i)
    set(static_cast<std::size_t>(i),
        is_byte ? static_cast<Wide>(column.at<std::uint8_t>(i)) : column.at<Wide>(i));
}

// Fields that no point has got anything of; of several times one is enough.
std::vector<std::string> fields_left_out(const PcdFile& file, bool has_times) {
  constexpr std::array<std::string_view, 6> kTaken = {"x", "y", "z", "intensity", "ring", "tag"};
  const auto is_in = [](const auto& list, const std::string& name) {
    return std::find(list.begin(), list.end(), name) != list.end();
  };
  std::vector<std::string> names;
  for (const PcdField& field : file.fields)
    if (!field.is_padding() && !is_in(kTaken, field.name) && !(has_times && is_in(kTimes, field.name)))
      names.push_back(fmt::format("{} ({})", field.name, type_of(field)));
  return names;
}

}  // namespace

KittiScan scan_of_points(const fs::path& path, const PcdFile& file, std::uint32_t end_ns) {
  const PcdColumn x = pcd_column(path, file, "x", 'F', 4), y = pcd_column(path, file, "y", 'F', 4),
                  z = pcd_column(path, file, "z", 'F', 4);
  KittiScan scan;
  std::vector<LidarPoint>& points = scan.points;
  for (std::int64_t i = 0; i < file.points; ++i)
    points.push_back({x.at<float>(i), y.at<float>(i), z.at<float>(i), 0, end_ns});
  read_column<float>(path, file, "intensity", 'F', [&](auto i, float value) { points[i].intensity = value; });
  read_column<std::uint16_t>(path, file, "ring", 'U', [&](auto i, auto value) { points[i].ring = value; });
  read_column<std::uint8_t>(path, file, "tag", 'U', [&](auto i, auto value) { points[i].tag = value; });
  scan.left_out = fields_left_out(file, read_times(path, file, points));
  return scan;
}

KittiScan read_kitti_scan(const fs::path& path, std::uint32_t end_ns) {
  return path.extension() == ".bin" ? KittiScan{read_bin(path, end_ns), {}}
                                    : scan_of_points(path, read_pcd(path), end_ns);
}

}  // namespace uniquadric
