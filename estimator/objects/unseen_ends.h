#pragma once

#include <Eigen/Core>

#include "estimator/window/long_window.h"

namespace uniquadric {

/// Where a shape reaches furthest in directions all around, but for what lies near points of its surface that
/// were seen (3 x n): (3 x m), in the body's frame [m]. `radius_m`: of the body's first sphere.
Eigen::Matrix3Xd unseen_ends(const Shape& shape, const Eigen::Matrix3Xd& seen, double radius_m);

}  // namespace uniquadric
