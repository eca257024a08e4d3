#pragma once

#include <filesystem>
#include <vector>

#include "simulator/scene/scene.h"
#include "simulator/scene/shape_reader.h"

namespace uniquadric {

class ConfigNode;

/// Reads an item of `world:` (placed by `pose`, id 0) or of `objects:` (id, name, motion). Files that its
/// mesh is made of are appended to `files`. `defaults` are the material's unless it says otherwise (an
/// object's seed is its id). Throws InputError with file and line.
Body read_static_body(const ConfigNode& node, const MaterialDefaults& defaults,
                      std::vector<std::filesystem::path>& files);
Body read_object(const ConfigNode& node, TextureAmount texture, std::vector<std::filesystem::path>& files);

/// A path named in a scene: ${VARIABLE} is replaced by the environment's value (UNIQUADRIC_DATA has a
/// default,
/// ../../shared/data beside the scene file), and a relative path counts from the scene file's folder.
std::filesystem::path resolve_path(const ConfigNode& node);

}  // namespace uniquadric
