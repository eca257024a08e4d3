#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <optional>
#include <vector>

#include "core/geometry/pose.h"
#include "core/sequence/ply.h"
#include "evaluation/statistics/statistics.h"

namespace uniquadric {

/// How well the surface that was seen of a body is that of the true one.
struct SurfaceError {
  Statistics error_m;  ///< distances of the points from the true surface
  double quantile_90_m = 0;
  Pose points_from_truth;   ///< how the two frames were laid on each other
  double within_m = 0;      ///< of `completeness`: kWithinDiagonal of the true points' tight box
  double completeness = 0;  ///< share of the true surface's area that has a point within within_m
};

inline constexpr double kWithinDiagonal = 0.05;         ///< ours: points averaged in voxels are 3 % apart
inline constexpr std::size_t kSurfaceSamples = 10'000;  ///< ours: 0.5 % of a half in `completeness`

/// The box about a mesh's triangles [m]; empty without any.
Eigen::AlignedBox3d surface_box(const SurfaceFile& mesh);

/// Points evenly spread over a mesh's area, the same in every run; none of a mesh without area.
std::vector<Eigen::Vector3d> sample_surface(const SurfaceFile& mesh, std::size_t samples);

/// `truth` is a mesh; of the estimate points count, or of a mesh kSurfaceSamples of its surface. A point of
/// the estimate lies at truth_from_estimate * (scale * p). Nothing where one of them has no area or point.
std::optional<SurfaceError> surface_error(const SurfaceFile& truth, const SurfaceFile& estimate,
                                          const Pose& truth_from_estimate, double scale = 1);

}  // namespace uniquadric
