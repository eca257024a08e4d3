#pragma once

#include <string>

#include "core/geometry/camera.h"

namespace uniquadric {

class ConfigNode;

/// A camera as kalibr and EuRoC describe it: `camera_model: pinhole`, `resolution` [w, h], `intrinsics`
/// [fx, fy, cx, cy], `distortion_model` (radtan, radial-tangential, none) and, under `coefficients`, [k1, k2,
/// p1, p2]. Throws InputError with file and line for all other models.
Camera read_pinhole_camera(const ConfigNode& node, const std::string& coefficients);

/// A camera of OpenCV-style settings, `Camera.fx` and so on (ORB-SLAM's): fx, fy, cx, cy, width, height and,
/// where they are there, k1, k2, p1, p2, k3.
Camera read_settings_camera(const ConfigNode& node);

}  // namespace uniquadric
