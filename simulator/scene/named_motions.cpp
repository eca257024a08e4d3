#include "simulator/scene/named_motions.h"

#include <cmath>
#include <functional>
#include <numbers>

#include "core/base/error.h"
#include "simulator/scene/curve.h"

namespace uniquadric {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

class Formula final : public Motion::Curve {
 public:
  explicit Formula(std::function<Pose(double)> pose_at) : pose_at_(std::move(pose_at)) {}
  Pose at(double time_s) const override { return pose_at_(time_s); }

 private:
  std::function<Pose(double)> pose_at_;
};

Motion from_formula(std::function<Pose(double)> pose_at) {
  return Motion(std::make_shared<Formula>(std::move(pose_at)));
}

/// Columns right, down, forward (or forward, left, up) as a rotation.
Quaterniond from_axes(const Vector3d& x, const Vector3d& y, const Vector3d& z) {
  Eigen::Matrix3d R;
  R << x, y, z;
  return Quaterniond(R).normalized();
}

Quaterniond optical_axes(const Vector3d& forward, const Vector3d& up) {
  const Vector3d right = forward.cross(up).normalized();
  return from_axes(right, forward.cross(right), forward);
}

// In the frame that turns with the circle, the ball's turn per angle is constant: rolling, -(R/r) x, less the
// frame's own turn. So the orientation is a product of two exponentials, exact for any law of the angle.
Quaterniond rolled(const CircleOptions& o, const Quaterniond& world_from_circle, double angle) {
  const double turned = angle - o.start_rad;
  const Vector3d per_angle = -(o.radius_m / o.rolling_radius_m) * Vector3d::UnitX() - Vector3d::UnitZ();
  const Quaterniond world_from_start = world_from_circle * exp_so3(o.start_rad * Vector3d::UnitZ());
  return (world_from_circle * exp_so3(angle * Vector3d::UnitZ()) * exp_so3(turned * per_angle) *
          world_from_start.conjugate() * o.orientation)
      .normalized();
}

Pose on_circle(const CircleOptions& o, const Quaterniond& world_from_circle, double time_s) {
  const double angle = o.start_rad + o.rate_radps * time_s +
                       o.sway_rad * std::sin(2 * std::numbers::pi * time_s / o.sway_period_s);
  const Vector3d outward = world_from_circle * Vector3d(std::cos(angle), std::sin(angle), 0);
  const Vector3d position = o.center_m + o.radius_m * outward;
  const Vector3d forward = (o.rate_radps < 0 ? -1 : 1) * o.normal.cross(outward);
  switch (o.facing) {
    case CircleOptions::Facing::fixed:
      return {o.orientation, position};
    case CircleOptions::Facing::target:
      return look_at(position, o.target_m);
    case CircleOptions::Facing::rolling:
      return {rolled(o, world_from_circle, angle), position};
    case CircleOptions::Facing::tangent:
      break;
  }
  return {o.optical ? optical_axes(forward, o.normal) : from_axes(forward, o.normal.cross(forward), o.normal),
          position};
}

}  // namespace

Pose look_at(const Vector3d& position_m, const Vector3d& target_m, double roll_rad) {
  constexpr double kUpright = 1e-6;  // rad: nearer the vertical, upright means nothing
  const Vector3d forward = (target_m - position_m).normalized();
  if (!(forward.head<2>().norm() > kUpright))
    throw InputError("cannot look at this point: it lies straight above, below or at the camera");
  return {(optical_axes(forward, Vector3d::UnitZ()) * exp_so3(roll_rad * Vector3d::UnitZ())).normalized(),
          position_m};
}

Motion static_motion(const Pose& world_from_body) {
  return from_formula([=](double) { return world_from_body; });
}

Motion line_motion(const Pose& start, const Vector3d& velocity_mps, std::optional<double> rolling_radius_m) {
  const Vector3d turn_radps = rolling_radius_m
                                  ? Vector3d(Vector3d::UnitZ().cross(velocity_mps) / *rolling_radius_m)
                                  : Vector3d(Vector3d::Zero());
  return from_formula([=](double time_s) {
    return Pose{exp_so3(time_s * turn_radps) * start.rotation, start.translation + time_s * velocity_mps};
  });
}

Motion circle_motion(const CircleOptions& options) {
  const Quaterniond world_from_circle = Quaterniond::FromTwoVectors(Vector3d::UnitZ(), options.normal);
  return from_formula([=](double time_s) { return on_circle(options, world_from_circle, time_s); });
}

Motion swing_motion(const SwingOptions& o) {
  return from_formula([=](double time_s) {
    const double angle = o.amplitude_rad * std::sin(2 * std::numbers::pi * time_s / o.period_s + o.phase_rad);
    const Quaterniond swung = exp_so3(angle * o.axis);
    return Pose{swung * o.orientation, o.pivot_m - o.length_m * (swung * Vector3d::UnitZ())};
  });
}

Motion screw_motion(const ScrewOptions& o) {
  return from_formula([=](double time_s) {
    const double angle = o.rate_radps * time_s;
    const Quaterniond turned = exp_so3(angle * o.axis);
    const Vector3d along = o.pitch_m * angle / (2 * std::numbers::pi) * o.axis;
    return Pose{turned * o.start.rotation, o.point_m + turned * (o.start.translation - o.point_m) + along};
  });
}

Motion composed_motion(std::vector<Motion> parts) {
  return from_formula([parts = std::move(parts)](double time_s) {
    Pose pose;
    for (const Motion& part : parts) pose = pose * part.at(time_s);
    pose.rotation.normalize();
    return pose;
  });
}

}  // namespace uniquadric
