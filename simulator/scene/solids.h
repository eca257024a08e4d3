#pragma once

#include <Eigen/Core>
#include <vector>

#include "simulator/scene/shapes.h"

namespace uniquadric {

/// Parts that composed bodies are put together from; closed, outward, not textured beyond `material`.

/// A rounded box about `centre`.
std::vector<Mesh> block(const Eigen::Vector3d& centre, const Eigen::Vector3d& size_m, double radius_m,
                        const Material& material);

/// A box whose top (z = +height/2) is smaller than its base: a cabin, a pyramid's stump.
std::vector<Mesh> frustum(const Eigen::Vector3d& centre, const Eigen::Vector2d& base_m,
                          const Eigen::Vector2d& top_m, double height_m, const Material& material);

/// A wheel about `centre` whose axle runs along y.
std::vector<Mesh> wheel(const Eigen::Vector3d& centre, double radius_m, double width_m,
                        const Material& material);

/// The material of the n-th part of a body: the same style with another seed and colour.
Material part_material(const Material& body, std::uint64_t part, const Eigen::Vector3d& color);

}  // namespace uniquadric
