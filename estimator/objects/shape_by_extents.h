#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "estimator/shape/axis_fusion.h"
#include "estimator/shape/reach.h"
#include "estimator/window/long_window.h"

namespace uniquadric {

/// What the paper's long window goes by, with extents of single views in the place of Alg. 1's axes.
struct ExtentEvidence {
  const Camera& camera;
  const std::vector<ShapeView>& views;
  const std::deque<Pose>& boxes;  ///< body_from_box of Alg. 1's, one a keyframe
  double thin_sigma = 0.5;  ///< of a semi-axis that nothing tells, about what outlines are across, relative
  double least_m = 0;       ///< semi-axis that is taken for possible where no view shows more
  AxisFusionOptions fusion;
  LongWindowOptions long_window;
};

/// Solves for a quadric (q = 2). Two explanations are tried:
///   - a body with edges: its axes are those of Alg. 1's boxes where they agree, its extents what views
///     show, fused by Alg. 2 (Eq. 15); the outlines (Eq. 14) are off an ellipsoid's by what they are off the
///     found one, which is their sigma;
///   - an ellipsoid: its axes and extents are what the outlines tell, if views show what they would of it.
/// The second is taken where it is clearly the likelier, given that neither the outlines' noise is known nor
/// what the body's points are off a box or an ellipsoid by; it is tried where the boxes do not agree, as
/// those of a round body. An axis that nothing tells is taken for as long as the outlines are across their
/// longer way. Nothing without points and boxes.
std::optional<Shape> shape_by_extents(const ExtentEvidence& evidence, const Shape& before);

}  // namespace uniquadric
