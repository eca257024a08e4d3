#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "evaluation/metrics/figures.h"

namespace uniquadric {

struct MapOptions {
  /// Edge of the voxels that are compared [m], the maps' own times powers of two; nothing: the coarser of
  /// the two. A voxel is occupied where a cell in it is, else free where a cell in it is known.
  std::optional<double> resolution_m;
  /// What an occupied voxel of the estimate is where the true map knows nothing: wrong, or not counted.
  /// Nothing: wrong if the true map has no free voxel, that is lists surfaces alone (as `simulate`'s does),
  /// else not counted.
  std::optional<bool> unknown_is_free;
};

enum class Occupancy { unknown, free, occupied };

struct MapComparison {
  double resolution_m = 0;
  bool unknown_is_free = false;
  /// [true][estimate] by Occupancy; where neither knows anything: 0.
  std::array<std::array<std::uint64_t, 3>, 3> voxels{};
  std::uint64_t complete =
      0;  ///< true occupied ones with an occupied one of the estimate at most a voxel off

  std::uint64_t at(Occupancy truth, Occupancy estimate) const {
    return voxels[static_cast<std::size_t>(truth)][static_cast<std::size_t>(estimate)];
  }
};

/// Compares two maps of one world (.bt; the estimate also points of a .ply: compare_map_points). Throws
/// InputError for a file that cannot be read, a true map without an occupied voxel, an estimate that misses
/// more of them than can be looked through, and cells that are not a power of two apart.
MapComparison compare_maps(const std::filesystem::path& truth, const std::filesystem::path& estimate,
                           const MapOptions& options);

/// The same of points [m] in the true map's world: a voxel is occupied where a point is in it. Voxels have at
/// least kPointVoxel_m unless the options say otherwise. Throws InputError also for points beyond the tree's
/// reach, 2^15 voxels.
MapComparison compare_map_points(const std::filesystem::path& truth, const std::filesystem::path& estimate,
                                 const std::vector<Eigen::Vector3d>& points, const MapOptions& options);
inline constexpr double kPointVoxel_m = 0.25;  ///< ours: cells of our LiDAR map, whose means points are

/// Precision, recall, IoU of the occupied voxels; share of the known true voxels that the estimate does not
/// know; completeness.
Figures figures(const MapComparison& comparison);

}  // namespace uniquadric
