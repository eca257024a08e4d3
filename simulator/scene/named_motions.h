#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "simulator/scene/motion.h"

namespace uniquadric {

/// The pose of a camera (optical frame: x right, y down, z forward) at `position_m` that looks at `target_m`,
/// the world's z upright in the image but for `roll_rad` about the optical axis. Throws InputError when the
/// two points coincide or the view is straight up or down.
Pose look_at(const Eigen::Vector3d& position_m, const Eigen::Vector3d& target_m, double roll_rad = 0);

Motion static_motion(const Pose& world_from_body);

/// Constant velocity. With `rolling_radius_m` a ball or wheel of that radius rolls along without slip on a
/// floor below.
Motion line_motion(const Pose& start, const Eigen::Vector3d& velocity_mps,
                   std::optional<double> rolling_radius_m = {});

struct CircleOptions {
  enum class Facing { fixed, tangent, target, rolling };
  Eigen::Vector3d center_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();     ///< unit; the angle counts about it
  double radius_m = 1, start_rad = 0, rate_radps = 0.5;  ///< angle 0 lies at +x for a normal of +z
  double sway_rad = 0, sway_period_s = 10;  ///< angle(t) = start + rate t + sway sin(2 pi t / period)
  Facing facing = Facing::fixed;
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();  ///< fixed: always; rolling: at the start
  bool optical = false;  ///< tangent: the body's z (optical) or x axis points forwards
  Eigen::Vector3d target_m = Eigen::Vector3d::Zero();  ///< target: the optical axis points there
  double rolling_radius_m = 0.1;  ///< rolling: without slip on a floor that far below, along the normal
};
Motion circle_motion(const CircleOptions& options);

/// A pendulum: hangs `length_m` below the pivot and turns about the horizontal `axis` by
/// amplitude sin(2 pi t / period + phase), harmonic at every amplitude.
struct SwingOptions {
  Eigen::Vector3d pivot_m = Eigen::Vector3d::Zero(), axis = Eigen::Vector3d::UnitY();  ///< axis: unit
  double length_m = 1, amplitude_rad = 0.5, period_s = 2, phase_rad = 0;
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();  ///< when it hangs at rest
};
Motion swing_motion(const SwingOptions& options);

/// Turns about the line through `point_m` along `axis` (unit) while it moves `pitch_m` along it each turn.
struct ScrewOptions {
  Pose start;
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero(), axis = Eigen::Vector3d::UnitZ();
  double rate_radps = 1, pitch_m = 0;
};
Motion screw_motion(const ScrewOptions& options);

/// One motion after the other: `parts[i]` from `starts_s[i]` on (increasing), the first one before that, too.
Motion successive_motion(std::vector<Motion> parts, std::vector<double> starts_s);

/// The product of poses: each motion takes place in the frame that the ones before it carry.
Motion composed_motion(std::vector<Motion> parts);

}  // namespace uniquadric
