#pragma once

#include <Eigen/Geometry>
#include <deque>
#include <optional>

namespace uniquadric {

/// Where the axes of single-frame boxes lie.
struct UsualOrientation {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d sigma_rad = Eigen::Vector3d::Zero();  ///< about each of its axes: the boxes' scatter
};

/// Of many boxes' rotations the one that the others are nearest to, as a mode is (partial views are off in
/// ways of their own), moved to the median of what lies about it. Axes may be named as they come. Scatter is
/// taken from the median of absolute deviations: a ball's boxes have any orientation, and say so. Nothing for
/// none.
std::optional<UsualOrientation> usual_orientation(const std::deque<Eigen::Quaterniond>& boxes);

/// The orientation that `boxes` makes of one that was `before` with standard deviation `sigma_rad` about each
/// axis, axes named as before.
UsualOrientation updated_orientation(const Eigen::Quaterniond& before, double sigma_rad,
                                     const UsualOrientation& boxes);

}  // namespace uniquadric
