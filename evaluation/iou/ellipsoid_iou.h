#pragma once

#include "core/geometry/ellipsoid.h"

namespace uniquadric {

/// Intersection over union of two solid ellipsoids, good to 1e-8 for every pair of valid ones (finite poses,
/// semi-axes > 0) and exactly 1 for identical ones; both orders of the arguments give the same double. One
/// body is whitened to the unit ball and the pair is cut into slices normal to the other's shortest axis:
/// each slice is a disc and an ellipse, whose common area is exact; Gauss-Legendre quadrature runs between
/// the places where the slices' topology changes.
double ellipsoid_iou(const Ellipsoid& a, const Ellipsoid& b);

}  // namespace uniquadric
