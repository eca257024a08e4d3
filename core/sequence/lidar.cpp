#include "core/sequence/lidar.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "core/base/config.h"
#include "core/base/text.h"
#include "core/sequence/calibration.h"
#include "core/sequence/pcd.h"

namespace uniquadric {

namespace {

constexpr double kLeastShareOfScan = 0.1;  // ours: of its time; a wrong unit makes it a thousandth
constexpr double kMostShareOfScan = 1.5;   // likewise: a scan ends before the next but one begins

double at_least_0(const ConfigNode& node, const char* key) {
  const double value = node.get<double>(key);
  if (!(value >= 0)) node.at(key).fail(fmt::format("expected at least 0, found {}", value));
  return value;
}

LidarDataSheet read_data_sheet(const ConfigNode& node) {
  const LidarDataSheet sheet{at_least_0(node, "range_sigma_m"), at_least_0(node, "divergence_deg"),
                             at_least_0(node, "angle_sigma_deg")};
  node.refuse_unknown_keys();
  return sheet;
}

}  // namespace

// A surface anywhere in the width of the beam, evenly: a twelfth of its square.
double LidarDataSheet::beam_sigma_rad() const {
  return std::hypot(angle_sigma_deg, divergence_deg / std::sqrt(12.0)) * (std::numbers::pi / 180);
}

LidarCalibration read_lidar_calibration(const ConfigNode& node) {
  LidarCalibration lidar;
  lidar.pattern = node.get<std::string>("pattern");
  lidar.rate_hz = node.positive("rate_hz");
  lidar.camera_from_lidar = read_extrinsics(node.at("camera_from_lidar"));
  if (const auto noise = node.find("noise")) lidar.noise = read_data_sheet(*noise);
  node.refuse_unknown_keys();
  return lidar;
}

std::string lidar_yaml(const LidarCalibration& calibration) {
  std::string yaml =
      fmt::format("pattern: {}, rate_hz: {}, camera_from_lidar: {}", yaml_quoted(calibration.pattern),
                  calibration.rate_hz, extrinsics_yaml(calibration.camera_from_lidar));
  if (const auto& noise = calibration.noise)
    yaml += fmt::format(", noise: {{range_sigma_m: {}, divergence_deg: {}, angle_sigma_deg: {}}}",
                        noise->range_sigma_m, noise->divergence_deg, noise->angle_sigma_deg);
  return yaml;
}

void write_lidar_points(const std::filesystem::path& path, const std::vector<LidarPoint>& points) {
  PcdFile file;
  file.fields = {{"x"},
                 {"y"},
                 {"z"},
                 {"intensity"},
                 {"offset_time", 4, 'U'},
                 {"t", 4, 'U'},
                 {"time"},
                 {"ring", 2, 'U'},
                 {"tag", 1, 'U'}};
  file.points = static_cast<std::int64_t>(points.size());
  file.data.reserve(points.size() * static_cast<std::size_t>(file.point_size()));
  for (const LidarPoint& p : points) {
    for (const float value : {p.x, p.y, p.z, p.intensity}) file.put(value);
    file.put(p.offset_ns);
    file.put(p.offset_ns);
    file.put(static_cast<float>(p.offset_ns * 1e-9));
    file.put(p.ring);
    file.put(p.tag);
  }
  write_pcd(path, file);
}

std::vector<LidarPoint> read_lidar_points(const std::filesystem::path& path) {
  const PcdFile file = read_pcd(path);
  const PcdColumn x = pcd_column(path, file, "x", 'F', 4), y = pcd_column(path, file, "y", 'F', 4),
                  z = pcd_column(path, file, "z", 'F', 4),
                  intensity = pcd_column(path, file, "intensity", 'F', 4),
                  t = pcd_column(path, file, "t", 'U', 4), ring = pcd_column(path, file, "ring", 'U', 2),
                  tag = pcd_column(path, file, "tag", 'U', 1);
  std::vector<LidarPoint> points;
  points.reserve(static_cast<std::size_t>(file.points));
  for (std::int64_t i = 0; i < file.points; ++i)
    points.push_back({x.at<float>(i), y.at<float>(i), z.at<float>(i), intensity.at<float>(i),
                      t.at<std::uint32_t>(i), ring.at<std::uint16_t>(i), tag.at<std::uint8_t>(i)});
  return points;
}

std::optional<std::string> point_times_fault(std::int64_t widest_ns, double rate_hz) {
  const double share = 1e-9 * static_cast<double>(widest_ns) * rate_hz;
  if (widest_ns == 0 || (share >= kLeastShareOfScan && share <= kMostShareOfScan)) return std::nullopt;
  return fmt::format("the points' times span {:.3g} s of a scan{}, of {:.3g} s: in another unit?",
                     1e-9 * static_cast<double>(widest_ns), share < 1 ? " at most" : "", 1 / rate_hz);
}

}  // namespace uniquadric
