#pragma once

#include <filesystem>
#include <vector>

#include "simulator/lidar/lidar_scan.h"

namespace uniquadric {

class ConfigNode;

/// Reads the `lidar:` section of a scene (its keys: README.md of this folder) and refuses unknown keys. A CSV
/// pattern is appended to `files`. Throws InputError with file and line.
LidarRig read_lidar(const ConfigNode& node, std::vector<std::filesystem::path>& files);

/// The rig's body frame (x forward, y left, z up) lies at the camera's centre.
Pose camera_from_body();

}  // namespace uniquadric
