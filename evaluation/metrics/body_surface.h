#pragma once

#include <vector>

#include "core/geometry/pose.h"
#include "core/geometry/superquadric.h"
#include "core/sequence/ply.h"
#include "evaluation/metrics/surface_distance.h"

namespace uniquadric {

/// The surface of a superellipsoid in its frame as triangles: a grid on the sides of its box, its corners
/// moved towards the centre onto the body, so that the edges of near-boxes stay sharp. A box is exact.
SurfaceFile tessellate(const Superellipsoid& body);

/// A surface in its own frame to compare with others: keep one for many poses.
struct ReferenceSurface {
  SurfaceDistance distance;
  std::vector<Eigen::Vector3d> points;  ///< spread evenly over its area [m]
};
ReferenceSurface reference_surface(const SurfaceFile& mesh);

/// How alike two surfaces are.
struct SurfaceScore {
  double f1 = 0;         ///< of precision and recall
  double chamfer_m = 0;  ///< mean of the mean distances of each one's points from the other
};

/// Precision is the share of the estimate's points no farther than `within_m` from the truth, recall that of
/// the true points from the estimate. Asserts that both have points.
SurfaceScore surface_score(const ReferenceSurface& truth, const ReferenceSurface& estimate,
                           const Pose& truth_from_estimate, double within_m);

/// max(10 mm, 1 % of the greatest side of the true surface's box) [m].
double surface_tolerance_m(const SurfaceFile& truth);

}  // namespace uniquadric
