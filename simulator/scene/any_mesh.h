#pragma once

#include <algorithm>

#include "simulator/scene/scene.h"

namespace uniquadric {

/// Whether a mesh of the world or of an object is such.
template <typename Predicate>
bool any_mesh(const Scene& scene, const Predicate& is_such) {
  const auto has_one = [&](const Body& body) { return std::ranges::any_of(body.meshes, is_such); };
  return std::ranges::any_of(scene.world, has_one) || std::ranges::any_of(scene.objects, has_one);
}

/// Whether some surface returns less of a depth sensor's light than others.
inline bool has_faint_surface(const Scene& scene) {
  return any_mesh(scene, [](const Mesh& mesh) { return mesh.depth_return < 1; });
}

}  // namespace uniquadric
