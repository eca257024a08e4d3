#include "evaluation/view_arc.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace uniquadric {

std::optional<Eigen::Vector3d> view_direction(const Pose& world_from_object, const Pose& world_from_camera) {
  const Eigen::Vector3d camera = relative_pose(world_from_object, world_from_camera).translation;
  const double distance_m = camera.norm();
  return distance_m > 0 ? std::optional<Eigen::Vector3d>(camera / distance_m) : std::nullopt;
}

std::vector<std::optional<double>> view_arcs_deg(
    const std::vector<std::optional<Eigen::Vector3d>>& directions) {
  std::vector<std::optional<double>> arcs;
  std::vector<Eigen::Vector3d> seen;
  double least_cosine = 1;
  for (const auto& direction : directions) {
    if (direction) {
      for (const Eigen::Vector3d& other : seen) least_cosine = std::min(least_cosine, direction->dot(other));
      seen.push_back(*direction);
    }
    if (seen.empty())
      arcs.emplace_back();
    else
      arcs.emplace_back(std::acos(std::max(-1.0, least_cosine)) * 180 / std::numbers::pi);
  }
  return arcs;
}

}  // namespace uniquadric
