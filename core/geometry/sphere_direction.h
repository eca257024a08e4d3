#pragma once

#include <Eigen/Core>

namespace uniquadric {

/// Unit vector `index` of `count` that lie evenly over the whole sphere, from +z to -z: Fibonacci's lattice
/// (R. Swinbank and R. J. Purser, "Fibonacci grids: a novel approach to global modelling", 2006, eq. 1).
Eigen::Vector3d sphere_direction(int index, int count);

}  // namespace uniquadric
