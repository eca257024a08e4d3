#pragma once

#include <Eigen/Core>
#include <memory>

namespace ceres {
class CostFunction;
}

namespace uniquadric {

/// A measured point of the surface, in the body's frame, lies on the superellipsoid:
///   r = (g - 1) / |grad g| / sigma_m
/// with g the gauge of the shape at body_from_shape^-1 p: the signed distance to the surface [m], positive
/// outside, to first order in the distance (Taubin's). On a box's face it is exact; the radial distance
/// |x| (1 - 1/g) would be |x| / a times as large.
/// Blocks: body_from_shape (7), ln a (3), exponents (`exponents` = 1 or 3).
std::unique_ptr<ceres::CostFunction> surface_point_factor(const Eigen::Vector3d& point_in_body_m,
                                                          double sigma_m, int exponents);

}  // namespace uniquadric
