#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "core/geometry/pose.h"

namespace uniquadric {

/// From this arc of views on a shape should be known. ours: the least arc over which the axes are asked to
/// hold.
inline constexpr double kWideArc_deg = 40;

/// Unit vector from an object's centre to the camera's, in the object's own frame; nothing where both are one
/// point.
std::optional<Eigen::Vector3d> view_direction(const Pose& world_from_object, const Pose& world_from_camera);

/// The arc of views up to each frame [deg]: the largest angle between any two of the `directions` (unit
/// vectors, empty where the object is not seen) so far; empty before the first. Each direction is held
/// against all before it: 3000 frames cost 4.5 million scalar products, a hundredth of a second.
std::vector<std::optional<double>> view_arcs_deg(
    const std::vector<std::optional<Eigen::Vector3d>>& directions);

}  // namespace uniquadric
