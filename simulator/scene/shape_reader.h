#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "simulator/scene/mesh.h"
#include "simulator/scene/texture.h"

namespace uniquadric {

class ConfigNode;

constexpr double kLargestBody_m = 10000;  ///< beyond it single precision is coarser than a millimetre

struct SceneShape {
  std::string name;  ///< of the primitive
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();
  std::vector<Mesh> meshes;
};

/// What a scene's bodies have unless they say otherwise.
struct MaterialDefaults {
  std::uint64_t seed = 0;
  TextureAmount amount = TextureAmount::rich;
  bool is_painted = true;
};

/// `texture: rich | sparse | none` of a map.
TextureAmount read_texture_amount(const ConfigNode& node, TextureAmount fallback);

/// Reads `primitive`, `size_m`, the primitive's own keys and `material` of a body's map and builds the
/// meshes. Leaves other keys to the caller's check. Throws InputError with file and line.
SceneShape read_shape(const ConfigNode& node, const MaterialDefaults& defaults);

/// A number from 0 to 1. Throws InputError with file and line.
double read_share(const ConfigNode& node, const std::string& key, double fallback);

}  // namespace uniquadric
