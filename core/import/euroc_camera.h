#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string_view>

#include "core/import/recording.h"

namespace uniquadric {

class ConfigNode;

// Parts of the EuRoC reader; they throw InputError with file and line.

std::int64_t read_euroc_stamp(const std::filesystem::path& path, int line, std::string_view field);
/// T_BS of a sensor.yaml.
Pose read_body_from_sensor(const ConfigNode& sensor);

/// cam0/ or cam1/.
struct EurocCamera {
  std::filesystem::path folder;
  Camera camera;
  Pose body_from_camera;
  std::map<std::int64_t, std::filesystem::path> images;  // by stamp
};

EurocCamera read_euroc_camera(const std::filesystem::path& folder);

/// Frames of the camera's images as they are.
void add_images(const EurocCamera& camera, Recording& recording);
/// Frames of the left camera's images, rectified, and depth where the right one has the same stamp; `left`
/// becomes the camera that sees them.
void add_stereo(EurocCamera& left, const EurocCamera& right, Recording& recording);

}  // namespace uniquadric
