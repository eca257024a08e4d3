#pragma once

#include <optional>
#include <vector>

#include "core/geometry/camera.h"
#include "estimator/shape/reach.h"
#include "estimator/window/long_window.h"

namespace uniquadric {

/// Where the free tangents of an outline touch it: each between those beside it, in the order of
/// `silhouette.support`.
std::vector<OutlineTouch> outline_touches(const Camera& camera, const Silhouette& silhouette);

/// How far a body reaches at least along an axis of a shape, from its middle [m], by the outlines whose
/// tangents face that way: what a tangent touches lies on its plane, between the lines of sight where it
/// touches, and in the other axes within the shape's box. Wherever it lies there, it is no nearer than this.
/// `sign`: 1 or -1, of the axis. Nothing where no outline faces it.
std::optional<double> reach_by_outlines(const Shape& shape, const std::vector<PointView>& views, int axis,
                                        int sign);

}  // namespace uniquadric
