#pragma once

#include "core/geometry/pose.h"
#include "simulator/scene/motion.h"

namespace uniquadric {

class ConfigNode;

/// What moves: a camera's poses are those of its optical frame, and only a camera may look at a point.
enum class Mover { body, camera };

/// Reads position_m and one of rpy_deg, quaternion_xyzw, look_at_m (with roll_deg) from the keys of a map.
/// Leaves other keys to the caller's check. Throws InputError with file and line.
Pose read_pose(const ConfigNode& node, Mover mover);

/// Roll, pitch, yaw [deg]: the body turns by yaw about z, then pitch about the new y, then roll about the new
/// x.
Eigen::Quaterniond read_rpy_deg(const ConfigNode& node);

/// Reads `kind: static|line|circle|swing|screw|spline|compose` and its keys (scenes/README.md); refuses
/// unknown ones.
Motion read_motion(const ConfigNode& node, Mover mover);

}  // namespace uniquadric
