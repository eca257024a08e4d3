#pragma once

#include <filesystem>
#include <limits>
#include <span>
#include <vector>

#include "simulator/scene/mesh.h"
#include "simulator/scene/motion.h"
#include "simulator/scene/pose_reader.h"

namespace uniquadric {

/// What a motion is read for.
struct MotionScope {
  Mover mover;
  std::vector<std::filesystem::path>& files;  ///< files that the motion is made of are appended
  std::span<const Mesh> meshes = {};          ///< a body's, in its object frame; a camera has none
  double end_s = std::numeric_limits<double>::infinity();  ///< the scene's last frame
};

/// Reads `kind` and its keys (scenes/README.md); refuses unknown ones. Throws InputError with file and line.
Motion read_motion(const ConfigNode& node, const MotionScope& scope);

}  // namespace uniquadric
