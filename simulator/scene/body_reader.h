#pragma once

#include <filesystem>
#include <limits>
#include <vector>

#include "simulator/scene/scene.h"
#include "simulator/scene/shape_reader.h"

namespace uniquadric {

class ConfigNode;

/// Reads an item of `world:` (placed by `pose`, id 0) or of `objects:` (id, name, motion). Files that its
/// mesh and motion are made of are appended to `files`. `defaults` are the material's unless it says
/// otherwise (an object's seed is its id); the scene ends at `end_s`. Throws InputError with file and line.
Body read_static_body(const ConfigNode& node, const MaterialDefaults& defaults,
                      std::vector<std::filesystem::path>& files);
Body read_object(const ConfigNode& node, MaterialDefaults defaults, std::vector<std::filesystem::path>& files,
                 double end_s = std::numeric_limits<double>::infinity());

}  // namespace uniquadric
