#pragma once

#include <Eigen/Core>
#include <memory>

namespace ceres {
class CostFunction;
}

namespace uniquadric {

/// An axis of the object, 0 to 2, is parallel to a direction of the body (unit): what stands on a plane
/// stands on a face. r = the direction's two other components along the object's axes, over sigma_rad. Block:
/// body_from_object (7).
std::unique_ptr<ceres::CostFunction> axis_direction_factor(const Eigen::Vector3d& direction, int axis,
                                                           double sigma_rad);

}  // namespace uniquadric
