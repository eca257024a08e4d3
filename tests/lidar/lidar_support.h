#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "simulator/lidar/lidar_scan.h"
#include "simulator/lidar/scan_pattern.h"
#include "simulator/scene/scene.h"

namespace uniquadric {

inline constexpr double kDegree = 3.14159265358979323846 / 180;

struct Beam {
  std::int64_t time_ns = 0;
  Eigen::Vector3d direction, origin;
  int ring = 0;
};

/// Beams from..from + count - 1.
std::vector<Beam> beams_of(const ScanPattern& pattern, std::int64_t from, std::int64_t count);
/// The beam fired at that time, which must be one beam's alone.
Beam beam_at(const ScanPattern& pattern, std::int64_t time_ns);

/// Rows of beams over a square of `width_deg` about x, read from a table: n x n of them in `length_s`.
ScanPattern square_pattern(int n, double width_deg, double length_s);

/// A body of one mesh, moving. `color` is its reflectivity.
Body body(int id, Mesh mesh, Motion motion, float color = 0.5f);
/// A square in the body's y-z plane whose normal is -x.
Mesh square(double side_m);
/// Facets of a sphere, outside or inside visible alike; within radius (2 pi / segments)^2 / 8 of it.
Mesh sphere(double radius_m, int segments);

/// A rig without noise whose lidar frame is the path's own.
LidarRig exact_rig(ScanPattern pattern);
Pose path_at(const Motion& motion, std::int64_t time_ns);

/// Everything a driver and the simulator say of a scan, for comparisons byte by byte.
std::string bytes_of(const LidarScan& scan);

}  // namespace uniquadric
