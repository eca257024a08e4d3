#include "simulator/scene/named_motions.h"

#include <algorithm>
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
  explicit Formula(std::function<Kinematics(const Jet&)> formula) : formula_(std::move(formula)) {}
  Kinematics kinematics(double time_s) const override { return formula_(time_jet(time_s)); }

 private:
  std::function<Kinematics(const Jet&)> formula_;
};

Motion from_formula(std::function<Kinematics(const Jet&)> formula) {
  return Motion(std::make_shared<Formula>(std::move(formula)));
}

class Composition final : public Motion::Curve {
 public:
  explicit Composition(std::vector<Motion> parts) : parts_(std::move(parts)) {}
  Pose at(double time_s) const override {
    Pose pose;
    for (const Motion& part : parts_) pose = pose * part.at(time_s);
    pose.rotation.normalize();
    return pose;
  }
  Kinematics kinematics(double time_s) const override {
    Kinematics result;
    for (const Motion& part : parts_) result = result * part.kinematics(time_s);
    result.pose.rotation.normalize();
    return result;
  }

 private:
  std::vector<Motion> parts_;
};

class Succession final : public Motion::Curve {
 public:
  Succession(std::vector<Motion> parts, std::vector<double> starts_s)
      : parts_(std::move(parts)), starts_s_(std::move(starts_s)) {}
  Pose at(double time_s) const override { return part(time_s).at(time_s); }
  Kinematics kinematics(double time_s) const override { return part(time_s).kinematics(time_s); }

 private:
  const Motion& part(double time_s) const {
    const auto next = std::upper_bound(starts_s_.begin() + 1, starts_s_.end(), time_s);
    return parts_[static_cast<std::size_t>(next - starts_s_.begin()) - 1];
  }

  std::vector<Motion> parts_;
  std::vector<double> starts_s_;
};

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

Kinematics turned_by(const Quaterniond& rotation) {
  return at_rest({rotation, Vector3d::Zero()});
}

/// Harmonic motion on top of a uniform one: start + rate t + amplitude sin(2 pi t / period + phase).
Jet swaying(const Jet& time_s, double start, double rate, double amplitude, double period_s, double phase) {
  return start + (rate * time_s + amplitude * sin(phase + (2 * std::numbers::pi / period_s) * time_s));
}

// In the frame that turns with the circle, the ball's turn per angle is constant: rolling, -(R/r) x, less the
// frame's own turn. So the orientation is a product of two exponentials, exact for any law of the angle.
Kinematics rolled(const CircleOptions& o, const Quaterniond& world_from_circle, const Jet& angle) {
  const Vector3d per_angle = -(o.radius_m / o.rolling_radius_m) * Vector3d::UnitX() - Vector3d::UnitZ();
  const Quaterniond world_from_start = world_from_circle * exp_so3(o.start_rad * Vector3d::UnitZ());
  return turned_by(world_from_circle) * turning(Vector3d::UnitZ(), angle) *
         turning(per_angle, -o.start_rad + angle) * turned_by(world_from_start.conjugate() * o.orientation);
}

// x forward along the circle, z along its normal; for a camera z forward, y against the normal.
Kinematics along_tangent(const CircleOptions& o, const Quaterniond& world_from_circle, const Jet& angle) {
  const double quarter = (o.rate_radps < 0 ? -0.5 : 0.5) * std::numbers::pi;
  const Kinematics forward = turned_by(world_from_circle) * turning(Vector3d::UnitZ(), quarter + angle);
  return o.optical ? forward * turned_by(optical_axes(Vector3d::UnitX(), Vector3d::UnitZ())) : forward;
}

// Yaw and elevation of the line of sight turn a camera that looked along x.
Kinematics looking_at(const Vector3d& target_m, const Kinematics& mover) {
  const auto sight = [&](int k) {
    return Jet{target_m[k] - mover.pose.translation[k], -mover.velocity_mps[k], -mover.acceleration_mps2[k]};
  };
  const Jet x = sight(0), y = sight(1), z = sight(2);
  const Pose pose = look_at(mover.pose.translation, target_m);  // throws where there is no such orientation
  Kinematics result = turning(Vector3d::UnitZ(), atan2(y, x)) *
                      turning(-Vector3d::UnitY(), atan2(z, hypot(x, y))) *
                      turned_by(optical_axes(Vector3d::UnitX(), Vector3d::UnitZ()));
  result.pose = pose;
  return result;
}

Kinematics facing(const CircleOptions& o, const Quaterniond& world_from_circle, const Jet& angle,
                  const Kinematics& mover) {
  switch (o.facing) {
    case CircleOptions::Facing::target:
      return looking_at(o.target_m, mover);
    case CircleOptions::Facing::rolling:
      return rolled(o, world_from_circle, angle);
    case CircleOptions::Facing::tangent:
      return along_tangent(o, world_from_circle, angle);
    case CircleOptions::Facing::fixed:
      break;
  }
  return turned_by(o.orientation);
}

Kinematics on_circle(const CircleOptions& o, const Quaterniond& world_from_circle, const Jet& time_s) {
  const Jet angle = swaying(time_s, o.start_rad, o.rate_radps, o.sway_rad, o.sway_period_s, 0);
  Kinematics result = at_rest({world_from_circle, o.center_m}) * turning(Vector3d::UnitZ(), angle) *
                      at_rest({Quaterniond::Identity(), o.radius_m * Vector3d::UnitX()});
  const Kinematics turn = facing(o, world_from_circle, angle, result);
  result.pose.rotation = turn.pose.rotation.normalized();
  result.angular_velocity_radps = turn.angular_velocity_radps;
  result.angular_acceleration_radps2 = turn.angular_acceleration_radps2;
  return result;
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
  return from_formula([=](const Jet&) { return at_rest(world_from_body); });
}

Motion line_motion(const Pose& start, const Vector3d& velocity_mps, std::optional<double> rolling_radius_m) {
  const Vector3d turn_radps = rolling_radius_m
                                  ? Vector3d(Vector3d::UnitZ().cross(velocity_mps) / *rolling_radius_m)
                                  : Vector3d(Vector3d::Zero());
  const Kinematics from = at_rest({Quaterniond::Identity(), start.translation}),
                   oriented = turned_by(start.rotation);
  return from_formula([=](const Jet& time_s) {
    return from * shifting(velocity_mps, time_s) * turning(turn_radps, time_s) * oriented;
  });
}

Motion circle_motion(const CircleOptions& options) {
  const Quaterniond world_from_circle = Quaterniond::FromTwoVectors(Vector3d::UnitZ(), options.normal);
  return from_formula([=](const Jet& time_s) { return on_circle(options, world_from_circle, time_s); });
}

Motion swing_motion(const SwingOptions& o) {
  const Kinematics pivot = at_rest({Quaterniond::Identity(), o.pivot_m}),
                   hung = at_rest({o.orientation, -o.length_m * Vector3d::UnitZ()});
  return from_formula([=](const Jet& time_s) {
    return pivot * turning(o.axis, swaying(time_s, 0, 0, o.amplitude_rad, o.period_s, o.phase_rad)) * hung;
  });
}

Motion screw_motion(const ScrewOptions& o) {
  const Kinematics point = at_rest({Quaterniond::Identity(), o.point_m}),
                   start = at_rest({o.start.rotation, o.start.translation - o.point_m});
  return from_formula([=](const Jet& time_s) {
    const Jet angle = o.rate_radps * time_s;
    return point * shifting(o.pitch_m / (2 * std::numbers::pi) * o.axis, angle) * turning(o.axis, angle) *
           start;
  });
}

Motion successive_motion(std::vector<Motion> parts, std::vector<double> starts_s) {
  return Motion(std::make_shared<Succession>(std::move(parts), std::move(starts_s)));
}

Motion composed_motion(std::vector<Motion> parts) {
  return Motion(std::make_shared<Composition>(std::move(parts)));
}

}  // namespace uniquadric
