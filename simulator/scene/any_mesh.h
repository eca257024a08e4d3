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

}  // namespace uniquadric
