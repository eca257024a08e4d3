#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/import/kitti_files.h"
#include "core/sequence/pcd.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr float kFullIntensity = 255;  // of a point; KITTI's reflectance is from 0 to 1
constexpr std::size_t kValues = 4;     // x y z reflectance
constexpr float kLongestScanS = 4;     // what 32 bits of nanoseconds hold

std::vector<LidarPoint> read_bin(const fs::path& path, std::uint32_t end_ns) {
  const std::string bytes = read_text(path);
  constexpr std::size_t kPointSize = kValues * sizeof(float);
  if (bytes.size() % kPointSize != 0)
    throw InputError(path,
                     fmt::format("is {} bytes, no whole number of points of {}", bytes.size(), kPointSize));
  std::vector<LidarPoint> points;
  for (std::size_t at = 0; at < bytes.size(); at += kPointSize) {
    float v[kValues];
    std::memcpy(v, bytes.data() + at, sizeof v);
    points.push_back({v[0], v[1], v[2], v[3] * kFullIntensity, end_ns});
  }
  return points;
}

bool has_field(const PcdFile& file, std::string_view name) {
  return std::any_of(file.fields.begin(), file.fields.end(),
                     [&](const PcdField& f) { return f.name == name; });
}

// The first of the flavours of time that the file has.
void read_times(const fs::path& path, const PcdFile& file, std::vector<LidarPoint>& points) {
  for (const char* name : {"t", "offset_time"}) {
    if (!has_field(file, name)) continue;
    const PcdColumn column = pcd_column(path, file, name, 'U', 4);
    for (std::int64_t i = 0; i < file.points; ++i) points[i].offset_ns = column.at<std::uint32_t>(i);
    return;
  }
  if (!has_field(file, "time")) return;
  const PcdColumn column = pcd_column(path, file, "time", 'F', 4);
  for (std::int64_t i = 0; i < file.points; ++i) {
    const auto time = column.at<float>(i);
    if (!(time >= 0 && time <= kLongestScanS))
      throw InputError(path, fmt::format("point {}: time {} is not within a scan", i, time));
    points[i].offset_ns = static_cast<std::uint32_t>(std::lround(1e9 * static_cast<double>(time)));
  }
}

std::vector<LidarPoint> read_pcd_scan(const fs::path& path, std::uint32_t end_ns) {
  const PcdFile file = read_pcd(path);
  const PcdColumn x = pcd_column(path, file, "x", 'F', 4), y = pcd_column(path, file, "y", 'F', 4),
                  z = pcd_column(path, file, "z", 'F', 4);
  std::vector<LidarPoint> points;
  for (std::int64_t i = 0; i < file.points; ++i)
    points.push_back({x.at<float>(i), y.at<float>(i), z.at<float>(i), 0, end_ns});
  const auto each = [&](const char* name, char type, int size, auto set) {
    if (!has_field(file, name)) return;
    const PcdColumn column = pcd_column(path, file, name, type, size);
    for (std::int64_t i = 0; i < file.points; ++i) set(points[i], column, i);
  };
  each("intensity", 'F', 4, [](LidarPoint& p, const PcdColumn& c, auto i) { p.intensity = c.at<float>(i); });
  each("ring", 'U', 2, [](LidarPoint& p, const PcdColumn& c, auto i) { p.ring = c.at<std::uint16_t>(i); });
  each("tag", 'U', 1, [](LidarPoint& p, const PcdColumn& c, auto i) { p.tag = c.at<std::uint8_t>(i); });
  read_times(path, file, points);
  return points;
}

}  // namespace

std::vector<LidarPoint> read_kitti_scan(const fs::path& path, std::uint32_t end_ns) {
  return path.extension() == ".bin" ? read_bin(path, end_ns) : read_pcd_scan(path, end_ns);
}

}  // namespace uniquadric
