#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "core/geometry/pose.h"

namespace ceres {
class CostFunction;
}

namespace uniquadric {

/// Values of a cost's parameter blocks; a block of 7 is a pose.
using Blocks = std::vector<std::vector<double>>;

template <typename... Block>
Blocks blocks_of(const Block&... block) {
  return {std::vector<double>(block.begin(), block.end())...};
}

Eigen::VectorXd residuals_of(const ceres::CostFunction& cost, const Blocks& blocks);

/// Compares the cost's Jacobian of each block, on SE(3)'s tangent for poses, with central differences of its
/// residuals (Richardson's extrapolation of two steps).
void expect_jacobians(const ceres::CostFunction& cost, const Blocks& blocks, double tolerance = 1e-7);

/// Rotations at which every Jacobian is tested: generic, nearly none, and nearly half a turn.
std::array<Eigen::Quaterniond, 3> test_rotations();

}  // namespace uniquadric
