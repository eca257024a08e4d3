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

/// What single views say of a body's box along given axes, put together.
struct FusedExtents {
  AxisEstimate axes;                                   ///< semi-axes and their standard deviations [m]
  Eigen::Vector3d center_m = Eigen::Vector3d::Zero();  ///< along the axes
};

/// The semi-axes of a body along `axes` (columns, in the body's frame): each view's half extents of points,
/// fused by Alg. 2 with the uncertainty of each view. Across the line of sight a view shows both ends of a
/// body, along it the near one alone: of an axis at an angle phi to it an ellipsoid hides (1 - sin phi) of
/// the semi-axis beyond its horizon, a box nothing. Half of that, as a length, is the sample's delta; what
/// even the best view may have missed is added to the result's. If the ends are `round` the sample is what is
/// seen over the share that an ellipsoid shows, (1 + sin phi) / 2. `least_m`: semi-axis that is taken for
/// possible where no view shows more. The centre is that of the near ends moved inwards by the fused axes, of
/// the middle where both ends were seen. Views of bodies in part hidden count where there are no whole ones.
/// Nothing without points.
std::optional<FusedExtents> fuse_extents(const std::vector<PointView>& views, const Eigen::Matrix3d& axes,
                                         double least_m, BodyEnds ends, const AxisFusionOptions& fusion = {},
                                         const ViewExtentOptions& options = {});

/// The centre along `axes` that these views say a body of given semi-axes has.
Eigen::Vector3d center_of_extents(const std::vector<PointView>& views, const Eigen::Matrix3d& axes,
                                  const Eigen::Vector3d& semi_axes_m, BodyEnds ends,
                                  const ViewExtentOptions& options = {});

}  // namespace uniquadric
