#pragma once

#include <optional>
#include <string>

#include "core/sequence/tracks.h"

namespace uniquadric {

/// What the camera's poses look like instead of world_from_camera with quaternions x y z w: quaternions
/// w x y z, camera_from_world, or both. Judged by a reference (the truth's camera, or the given one): read
/// that way and aligned, the poses fit it far better. Nothing where they fit as they are, or where nothing
/// fits.
std::optional<std::string> camera_convention_fault(const Trajectory& reference, const Trajectory& estimate);

/// Whether the quaternions of a trajectory begin as the identity in the order w x y z does: 1 0 0 0. All that
/// can be said without a reference: the steps between poses have the same angles in either order.
std::optional<std::string> first_quaternion_fault(const Trajectory& trajectory);

/// The order of the quaternions of an object's poses, by its turns in the true world since its first pose.
/// `estimate` is as it was read; `truth_from_estimate` carries its world onto the reference's.
std::optional<std::string> object_convention_fault(const Trajectory& reference, const Trajectory& estimate,
                                                   const Pose& truth_from_estimate);

}  // namespace uniquadric
