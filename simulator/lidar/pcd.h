#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/geometry/pose.h"
#include "simulator/lidar/lidar_scan.h"

namespace uniquadric {

struct PcdField {
  std::string name;
  int size = 4;     ///< bytes
  char type = 'F';  ///< F, I or U
};

/// A PCD 0.7 file with binary data.
struct PcdFile {
  std::vector<PcdField> fields;
  std::int64_t points = 0;
  Pose viewpoint;    ///< VIEWPOINT: translation, then quaternion w x y z
  std::string data;  ///< points in turn, their fields packed, little-endian

  int point_size() const;
};

/// Throws std::runtime_error when the file cannot be written; it is never seen half-written.
void write_pcd(const std::filesystem::path& path, const PcdFile& file);

/// Throws InputError naming file (and line, in the header) for a header that is incomplete or contradicts
/// itself or its data, for data that are not binary, and for fields of more than one value.
PcdFile read_pcd(const std::filesystem::path& path);

/// A scan as a driver writes it: x y z intensity (F4), the time since the scan's start in the three flavours
/// readers look for, offset_time and t (U4, ns) and time (F4, s), ring (U2), tag (U1). The viewpoint is the
/// identity: where the sensor was is not its observation.
PcdFile points_pcd(const LidarScan& scan);

/// What the simulator knows of the same points, in the same order: range (F4, m, without noise),
/// incidence_cos (F4), instance (U2), kind (U1: 0 surface, 1 of several bodies, 2 false alarm). The viewpoint
/// is the sensor's pose at the scan's start.
PcdFile truth_pcd(const LidarScan& scan, const Pose& world_from_lidar);

/// Points of a file as points_pcd() writes it; further fields are passed over. Throws InputError naming the
/// file and a field that is missing or of another type.
std::vector<LidarPoint> read_points(const std::filesystem::path& path);
std::vector<LidarPointTruth> read_point_truth(const std::filesystem::path& path);

}  // namespace uniquadric
