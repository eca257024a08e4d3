#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "core/geometry/pose.h"
#include "evaluation/metrics/figures.h"
#include "evaluation/metrics/surface_distance.h"
#include "evaluation/statistics/statistics.h"

namespace uniquadric {

struct SurfaceOptions {
  Pose points_from_surface;  ///< where the surface stands in the points' frame
  double within_m = 0.05;    ///< ours: some widths of a LiDAR's noise
};

struct SurfaceComparison {
  std::uint64_t not_finite = 0;  ///< points without coordinates, as depth cameras write them; not judged
  Statistics distance_m;
  double quantile_95_m = 0;
  double within_m = 0;
  std::optional<double> share_within;
};

inline constexpr double kMostCoordinate_m = 1e9;  ///< of what is compared, as of tracks

/// How far the points of a PCD file (x, y, z as 4-byte floats [m]) or a PLY (read_surface_ply) lie off a
/// surface. Throws InputError naming the file for one that cannot be read, one without a finite point, and a
/// point beyond kMostCoordinate_m.
SurfaceComparison compare_to_surface(const std::filesystem::path& points, const SurfaceDistance& surface,
                                     const SurfaceOptions& options);

Figures figures(const SurfaceComparison& comparison);

}  // namespace uniquadric
