#pragma once

#include "simulator/scene/motion.h"
#include "simulator/scene/pose_reader.h"

namespace uniquadric {

/// Reads `kind: static|line|circle|swing|screw|spline|compose` and its keys (scenes/README.md); refuses
/// unknown ones. Throws InputError with file and line.
Motion read_motion(const ConfigNode& node, Mover mover);

}  // namespace uniquadric
