#pragma once

#include <filesystem>
#include <vector>

#include "simulator/lidar/lidar_scan.h"

namespace uniquadric {

class ConfigNode;

/// Reads the `lidar:` section of a scene (its keys: README.md of this folder) and refuses unknown keys. A CSV
/// pattern is appended to `files`. Throws InputError with file and line.
LidarRig read_lidar(const ConfigNode& node, std::vector<std::filesystem::path>& files);

}  // namespace uniquadric
