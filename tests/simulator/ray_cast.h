#pragma once

#include <Eigen/Core>
#include <optional>

#include "simulator/render/renderer.h"

namespace uniquadric {

struct RayHit {
  double z_m = 0;     ///< along the optical axis
  int id = 0;         ///< of the body, 0 for the world
  double margin = 0;  ///< distance from the hit triangle's edges in barycentric units
};

/// What the ray through pixel (u, v) meets first, by intersecting every triangle (Moeller and Trumbore, 1997)
/// in double: a second way to what the renderer draws.
std::optional<RayHit> cast_ray(const Scene& scene, const ScenePoses& poses, double u, double v);

}  // namespace uniquadric
