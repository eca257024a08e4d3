#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace uniquadric {

/// The share of a histogram's errors in [from_m, to_m); the outer two are unbounded.
struct ErrorCell {
  double from_m = 0, to_m = 0;
  std::int64_t beams = 0;
};

/// The paper's way to a LiDAR (depth image -> points -> octree -> pattern) against Embree over the same beams
/// without noise, of one simulated sequence: what `simulate` writes for `method: depth_octree`.
struct LidarRoutes {
  std::string scene;
  std::uint64_t seed = 0;
  std::int64_t scans = 0;
  std::int64_t beams = 0, matched = 0, lost = 0, extra = 0;  ///< with a range of either, both, Embree, octree
  double mean_m = 0, rms_m = 0;                ///< of octree minus Embree, over all matched beams
  double median_abs_m = 0, p95_abs_m = 0;      ///< medians over scans of each scan's figure
  std::vector<ErrorCell> errors;               ///< in order of the error
  std::optional<double> octree_ms, embree_ms;  ///< a scan, one thread each; as measured

  double completeness() const;  ///< matched over what Embree has; 1 when that has nothing
  /// How many times as fast as the octree Embree makes a scan.
  std::optional<double> speed_ratio() const;
  std::int64_t beyond() const;  ///< beams in the outer two cells
};

/// Reads `folder`: comparison.csv, errors.csv and, where there is one, timing.csv. Nothing when there is no
/// comparison.csv. Throws InputError with file and line.
std::optional<LidarRoutes> read_lidar_routes(const std::filesystem::path& folder, const std::string& scene,
                                             std::uint64_t seed);

/// A section of report.md; empty when there is nothing to show.
std::string lidar_markdown(const std::vector<LidarRoutes>& routes);

}  // namespace uniquadric
