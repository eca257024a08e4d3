#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "simulator/scene/mesh.h"

namespace uniquadric {

/// How far points lie off the triangles of a body (Embree's point query).
class SurfaceDistance {
 public:
  explicit SurfaceDistance(const std::vector<Mesh>& meshes);
  /// Distance [m] of a point in the body's frame to the nearest triangle; `most_m` where none is nearer.
  double at(const Eigen::Vector3d& point, double most_m = 100) const;

 private:
  struct State;
  std::shared_ptr<const State> state_;
};

}  // namespace uniquadric
