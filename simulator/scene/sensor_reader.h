#pragma once

#include <string_view>

#include "simulator/scene/scene.h"

namespace uniquadric {

class ConfigNode;

/// Reads the sections light, depth_noise, image_noise, segmenter and imu of a scene and keeps lidar for its
/// own reader; what is absent keeps its default. Throws InputError with file and line.
void read_sensor_models(const ConfigNode& root, Scene& scene);

/// Warns of keys of a scene as it was given, without what its realism sets, that count for nothing in
/// `scene`.
void warn_of_idle_keys(const ConfigNode& given, const Scene& scene);

/// Whether this key of depth_noise counts for its model `stereo` alone.
bool is_of_stereo_alone(std::string_view key);

/// camera.calibration_error.
CalibrationError read_calibration_error(const ConfigNode& node);

}  // namespace uniquadric
