#pragma once

#include <Eigen/Core>
#include <vector>

namespace uniquadric {

/// Heights z of the points of an axis-aligned ellipsoid's surface where the distance from the origin is
/// stationary. Every patch of the surface that lies inside (or outside) the unit ball holds such a point, so
/// slices through them miss no patch, however small. Heights may also be listed that belong to no such point.
std::vector<double> stationary_slices(const Eigen::Vector3d& center, const Eigen::Vector3d& semi_axes);

}  // namespace uniquadric
