#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace uniquadric {

/// A change of axes, each of which becomes plus or minus another: p_new = matrix * p_old.
struct AxisTurn {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
  std::string name;  ///< the new x, y, z in the old axes, as "-y -z x"
};

/// All 48, the identity first; the proper ones alone are the 24 rotations.
std::vector<AxisTurn> axis_turns();
std::vector<AxisTurn> proper_axis_turns();

}  // namespace uniquadric
