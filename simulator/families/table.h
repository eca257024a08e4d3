#pragma once

#include <string>

#include "simulator/families/scene_draft.h"

namespace uniquadric {

inline const Eigen::Vector3d kTable_m(1.5, 1.0, 0.72);

/// A room of 6 m with a table in its middle.
void add_room_with_table(RandomStream& random, const FamilyOptions& options, SceneDraft& draft);

/// A place at which the thing stands on the table altogether, and the nearest such to another one.
Eigen::Vector2d place_on_table(RandomStream& random, const Thing& thing);
Eigen::Vector2d onto_table(const Thing& thing, const Eigen::Vector2d& at_m);

/// A camera in a hand: an arc of `arc_deg` about the middle of the table, and tremor.
std::string hand_held_camera(RandomStream& random, const FamilyOptions& options, double arc_deg);

/// Motions as SceneDraft takes them.
std::string static_motion_text(const Eigen::Vector3d& at_m, const Eigen::Vector3d& rpy_deg);
inline constexpr const char* kSplineHead =
    "      kind: spline\n      may_overshoot: true\n      waypoints:\n";
std::string waypoint_text(double time_s, const Eigen::Vector3d& at_m, const Eigen::Vector3d& rpy_deg,
                          double hold_s = 0);

}  // namespace uniquadric
