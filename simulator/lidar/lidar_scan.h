#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "core/geometry/pose.h"
#include "core/sequence/lidar.h"
#include "simulator/lidar/lidar_noise.h"
#include "simulator/lidar/ray_caster.h"
#include "simulator/lidar/scan_pattern.h"
#include "simulator/lidar/sensor_path.h"

namespace uniquadric {

/// A beam's width and what becomes of several surfaces in it.
struct LidarBeam {
  enum class Return { first, strongest, last };
  double vertical_deg = 0.28, horizontal_deg = 0.03;  ///< full widths (Livox)
  int vertical_rays = 1, horizontal_rays = 1;  ///< evenly over the beam; ours: 1 x 1, a beam without width
  double merge_m = 0.6;                        ///< surfaces no farther apart than this give one mixed echo
  Return returned = Return::strongest;

  int rays() const { return vertical_rays * horizontal_rays; }
};

enum class LidarMethod {
  embree,       ///< every point is cast where sensor and bodies are at its own time
  depth_octree  ///< paper: depth image -> points -> octree -> the pattern cast through it (depth_octree.h)
};

/// A LiDAR as a scene describes it (README.md of this folder).
struct LidarRig {
  std::string pattern_name = "livox_avia";  ///< or the CSV's file name
  ScanPattern pattern = named_pattern("livox_avia");
  double rate_hz = 10;     ///< scans a second
  Pose camera_from_lidar;  ///< lidar: x forward, y left, z up; camera: optical frame
  LidarNoise noise;
  LidarDataSheet data_sheet;  ///< what is said of the noise, whatever is simulated of it
  LidarBeam beam;
  CasterOptions caster;
  std::vector<std::pair<std::string, double>> reflectivity;  ///< by body name; over 1: retro-reflector
  LidarMethod method = LidarMethod::embree;
  double octree_resolution_m = 0.1;  ///< of depth_octree
  Pose mounting_error;               ///< the told camera_from_lidar is the true one times this
  double time_offset_s = 0;          ///< scans are stamped so late
  bool point_times = true;           ///< else all points are told the scan's start

  /// Scan k takes [start_ns(k), start_ns(k + 1)).
  std::int64_t start_ns(std::int64_t scan) const;
};

/// What the simulator knows of a point.
struct LidarPointTruth {
  enum class Kind : std::uint8_t { surface, mixed, false_alarm };
  float range_m = 0;           ///< without noise, from where the beam starts
  float incidence_cos = 0;     ///< between beam and normal
  std::uint16_t instance = 0;  ///< the object's id, 0: static world (or nothing, for a false alarm)
  Kind kind = Kind::surface;
};

struct LidarScan {
  std::int64_t start_ns = 0;
  std::int64_t beams = 0;  ///< fired; those that gave no point are the difference
  std::vector<LidarPoint> points;
  std::vector<LidarPointTruth> truth;  ///< one a point, in the same order
};

/// The lidar's trajectory on a moving camera.
PoseAt lidar_path(const Motion& world_from_camera, const LidarRig& rig);

/// Scan number `scan` of a rig. The same bytes for any number of `threads` (0: as many as there are); noise
/// depends on (seed, scan, beam) alone. Throws InputError when the pattern fires no beam in the scan.
LidarScan take_scan(const RayCaster& caster, const LidarRig& rig, const PoseAt& world_from_lidar,
                    std::int64_t scan, std::uint64_t seed, int threads = 1);

}  // namespace uniquadric
