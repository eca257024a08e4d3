#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/pose.h"

namespace uniquadric {

class ConfigNode;

/// What a LiDAR driver gives: coordinates in the lidar frame (x forward, y left, z up) at the point's own
/// time, so that the cloud carries the distortion of the sensor's and of the objects' motion.
struct LidarPoint {
  float x = 0, y = 0, z = 0;    ///< [m]
  float intensity = 0;          ///< 0..150 diffuse (0..100 %), 151..255 retro-reflectors
  std::uint32_t offset_ns = 0;  ///< since the scan's start
  std::uint16_t ring = 0;       ///< laser or line
  std::uint8_t tag = 0;  ///< bits 4-5: number of the echo in its beam (0 is the first), as Livox has it
};

/// A return by itself, once its scan no longer counts.
struct TimedPoint {
  std::int64_t stamp_ns = 0;
  Eigen::Vector3f lidar = Eigen::Vector3f::Zero();  ///< in the lidar's frame at that time [m]
};

/// What the data sheet of a LiDAR's model says of its errors, standard deviations. The defaults are a Livox
/// Avia's, and count where a sequence says nothing.
struct LidarDataSheet {
  double range_sigma_m = 0.02;
  double divergence_deg = 0.28;   ///< full width of the beam
  double angle_sigma_deg = 0.05;  ///< of the beam's direction, in each transverse axis

  /// Of a point across its beam, a metre away: the direction's error, and where in the width of the beam the
  /// surface is that came back.
  double beam_sigma_rad() const;
};

/// Section `lidar` of sequence.yaml.
struct LidarCalibration {
  std::string pattern;  ///< name of the scan pattern, or of its file
  double rate_hz = 10;  ///< scans a second
  Pose camera_from_lidar;
  std::optional<LidarDataSheet> noise{};  ///< nothing: not known
};
LidarCalibration read_lidar_calibration(const ConfigNode& node);
std::string lidar_yaml(const LidarCalibration& calibration);

/// A scan as a driver writes it, PCD 0.7: x y z intensity (F4), the time since the scan's start in the three
/// flavours readers look for, offset_time and t (U4, ns) and time (F4, s), ring (U2), tag (U1). The viewpoint
/// is the identity: where the sensor was is not its observation.
void write_lidar_points(const std::filesystem::path& path, const std::vector<LidarPoint>& points);

/// Points of a file as write_lidar_points() makes it; further fields are passed over. Throws InputError
/// naming the file and a field that is missing or of another type.
std::vector<LidarPoint> read_lidar_points(const std::filesystem::path& path);

/// What is wrong with points' times when of no scan they span more than `widest_ns`: where that is some, but
/// less than a tenth of a scan's time, or more than one and a half of it, the unit is in doubt. A sentence.
std::optional<std::string> point_times_fault(std::int64_t widest_ns, double rate_hz);

}  // namespace uniquadric
