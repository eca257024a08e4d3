#pragma once

#include <numbers>
#include <optional>
#include <string>

#include "core/base/config.h"
#include "core/geometry/pose.h"

namespace uniquadric {

/// What moves: a camera's poses are those of its optical frame, and only a camera may look at a point.
enum class Mover { body, camera };

inline double radians(double degrees) {
  return degrees * std::numbers::pi / 180;
}

/// These read their keys of a map, leave other keys to the caller's check and throw InputError with file and
/// line.

/// Roll, pitch, yaw [deg]: R = Rz(yaw) Ry(pitch) Rx(roll).
Eigen::Quaterniond read_rpy_deg(const ConfigNode& node);

/// One of rpy_deg, quaternion_xyzw, look_at_m (with roll_deg); with none of them the look at `target`, or
/// identity.
Eigen::Quaterniond read_orientation(const ConfigNode& node, Mover mover, const Eigen::Vector3d& position_m,
                                    const std::optional<ConfigNode>& target = {});

/// position_m and an orientation.
Pose read_pose(const ConfigNode& node, Mover mover);

/// The frame of the rig that carries the camera: at the camera's centre, x forward, y left, z up.
Pose camera_from_body_axes();

/// Where a sensor sits on the camera's rig: `camera_from_SENSOR` or `body_from_SENSOR`
/// (camera_from_body_axes), each a pose; with neither, along the body's axes at the camera's centre. Result:
/// camera_from_sensor.
Pose read_mounting(const ConfigNode& node, const std::string& sensor);

/// `mounting_error`, a pose: what the told camera_from_sensor has behind the true one; none: identity.
Pose read_mounting_error(const ConfigNode& node);

}  // namespace uniquadric
