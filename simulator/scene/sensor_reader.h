#pragma once

#include "simulator/scene/scene.h"

namespace uniquadric {

class ConfigNode;

/// Reads the sections light, depth_noise, image_noise and segmenter of a scene; what is absent keeps its
/// default. Throws InputError with file and line.
void read_sensor_models(const ConfigNode& root, Scene& scene);

}  // namespace uniquadric
