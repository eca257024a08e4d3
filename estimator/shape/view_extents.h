#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "estimator/shape/axis_fusion.h"
#include "estimator/shape/reach.h"

namespace uniquadric {

/// What a body's ends are like where they turn out of sight.
enum class BodyEnds {
  edges,  ///< a box's: what is seen ends where the body does, or may hide as much as an ellipsoid's
  round,  ///< an ellipsoid's
};

/// All numbers are ours.
struct ViewExtentOptions {
  double top_share = 0.005;     // of a view's points whose mean an end is
  double noise_m = 0.002;       // of half an extent of which both ends were seen
  double model = 0.02;          // of a semi-axis: a round end lies a few percent beyond that mean
  double near_cosine = 0.25;    // of axis and line of sight, from which on one end alone is the near one
  double scale_quantile = 0.9;  // of the views' half extents, by which what is hidden is measured
};

/// What one view shows of a body along given axes, from the body's origin [m].
struct ViewExtent {
  Eigen::Array3d low_m, high_m;
  Eigen::Array3d away;     ///< cosine of each axis with the line of sight
  double horizon_rad = 0;  ///< how far around an ellipsoid's points are seen
};

/// Of each view along `axes` (columns, in the body's frame). Views of bodies in part hidden count where there
/// are no whole ones.
std::vector<ViewExtent> view_extents(const std::vector<PointView>& views, const Eigen::Matrix3d& axes,
                                     BodyEnds ends, const ViewExtentOptions& options = {});

/// The semi-axes of a body: each view's half extents, fused by Alg. 2 with the uncertainty of each view.
/// Across the line of sight a view shows both ends of a body, along it the near one alone: of an axis at an
/// angle phi to it an ellipsoid hides (1 - sin phi) of the semi-axis beyond its horizon, a box nothing. Half
/// of that, as a length, is the sample's delta; what even the best view may have missed is added to the
/// result's. If the ends are `round` the sample is what is seen over the share that an ellipsoid shows,
/// (1 + sin phi) / 2. `least_m`: semi-axis that is taken for possible where no view shows more. Nothing
/// without views.
std::optional<AxisEstimate> fuse_extents(const std::vector<ViewExtent>& views, double least_m, BodyEnds ends,
                                         const AxisFusionOptions& fusion = {},
                                         const ViewExtentOptions& options = {});

/// The centre along the axes that these views say a body of given semi-axes has: of the near ends moved
/// inwards by them, of the middle where both ends were seen.
Eigen::Vector3d center_of_extents(const std::vector<ViewExtent>& views, const Eigen::Vector3d& semi_axes_m,
                                  const ViewExtentOptions& options = {});

}  // namespace uniquadric
