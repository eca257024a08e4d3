#pragma once

#include <Eigen/Core>
#include <vector>

#include "simulator/scene/mesh.h"

namespace uniquadric {

/// The same surface in triangles that are small where a camera comes near: no edge is longer than half
/// of its middle's distance to the nearest of `cameras_m` (points in the mesh's frame), or than 5 cm. What
/// is interpolated over a triangle between its vertices' times errs by the square of that share.
Mesh with_short_edges(Mesh mesh, const std::vector<Eigen::Vector3f>& cameras_m);

}  // namespace uniquadric
