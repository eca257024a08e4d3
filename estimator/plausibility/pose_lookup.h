#pragma once

#include <cstdint>
#include <optional>

#include "core/sequence/trajectory.h"

namespace uniquadric {

/// The pose at a stamp, between its neighbours where these are no more than half a second apart; nothing
/// outside the trajectory, but for a millisecond.
std::optional<Pose> pose_near(const Trajectory& trajectory, std::int64_t stamp_ns);

}  // namespace uniquadric
