#pragma once

#include <Eigen/Core>

namespace uniquadric {

/// How an ellipse lies to a disc.
enum class DiscOverlap { disjoint, ellipse_inside, disc_inside, two_points, four_points };

struct DiscIntersection {
  DiscOverlap overlap = DiscOverlap::disjoint;  ///< by the number of points their outlines share
  double area = 0;
};

/// Exact area that the unit disc about the origin shares with the axis-aligned ellipse of this centre and
/// these semi-axes (both > 0), in the disc's units. The points where the outlines meet are bracketed between
/// the extrema of the distance from the origin, so none is missed; accurate to about 1e-15 of the disc.
DiscIntersection intersect_unit_disc(const Eigen::Vector2d& center, const Eigen::Vector2d& semi_axes);

}  // namespace uniquadric
