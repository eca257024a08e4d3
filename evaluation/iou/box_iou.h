#pragma once

#include "core/geometry/ellipsoid.h"

namespace uniquadric {

/// Intersection over union of two oriented boxes, exact but for rounding: the pose is the box's centre and
/// axes, the semi-axes are its half extents [m]. Exactly 1 for the same box twice. The common body is bounded
/// by the faces of each box clipped by the other; its volume follows from them by the divergence theorem.
double box_iou(const Ellipsoid& a, const Ellipsoid& b);

}  // namespace uniquadric
