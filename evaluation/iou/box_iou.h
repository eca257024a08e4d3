#pragma once

#include "core/geometry/ellipsoid.h"

namespace uniquadric {

/// Intersection over union of two oriented boxes: the pose is the box's centre and axes, the semi-axes are
/// its half extents [m]. Exact but for rounding, also for boxes that touch or share faces; exactly 1 for the
/// same box twice. The area of the common body's cross-sections normal to an axis of `a` is a quadratic
/// function of the height between the heights of its corners, so that Gauss-Legendre quadrature with two
/// nodes integrates it exactly.
double box_iou(const Ellipsoid& a, const Ellipsoid& b);

}  // namespace uniquadric
