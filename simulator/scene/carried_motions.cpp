#include "simulator/scene/carried_motions.h"

#include <algorithm>
#include <array>
#include <boost/math/quadrature/gauss.hpp>
#include <cmath>
#include <numbers>

#include "core/base/random.h"
#include "simulator/scene/curve.h"
#include "simulator/scene/pose_reader.h"

namespace uniquadric {
namespace {

using Eigen::Vector3d;

// Of the sway: those of the tremor lie between 8 and 12 Hz.
constexpr int kSways = 8, kTremors = 4;
constexpr double kTremorVariance = 0.1;

struct Wave {
  double amplitude = 0, rate_radps = 0, phase_rad = 0;
};
using Waves = std::array<Wave, kSways + kTremors>;

// Of unit root mean square: an amplitude a has the mean square a^2 / 2.
Waves draw_waves(std::uint64_t seed, std::uint32_t axis) {
  RandomStream random(seed, "tremor", 0, axis);
  Waves waves;
  double sway = 0;
  for (int i = 0; i < kSways + kTremors; ++i) {
    const bool is_sway = i < kSways;
    const double hz = is_sway ? 0.3 * std::pow(20, (i + random.uniform()) / kSways) : random.uniform(8, 12);
    waves[i] = {is_sway ? 1 / hz : std::sqrt(2 * kTremorVariance / kTremors), 2 * std::numbers::pi * hz,
                random.uniform(0, 2 * std::numbers::pi)};
    if (is_sway) sway += 0.5 / (hz * hz);
  }
  for (int i = 0; i < kSways; ++i) waves[i].amplitude *= std::sqrt((1 - kTremorVariance) / sway);
  return waves;
}

Jet sum_of(const Waves& waves, double scale, const Jet& time_s) {
  Jet sum;
  for (const Wave& wave : waves)
    sum = sum + scale * wave.amplitude * sin(wave.phase_rad + wave.rate_radps * time_s);
  return sum;
}

class Tremor final : public Motion::Curve {
 public:
  explicit Tremor(const TremorOptions& options) : options_(options) {
    for (std::uint32_t axis = 0; axis < 6; ++axis) waves_[axis] = draw_waves(options.seed, axis);
  }
  Kinematics kinematics(double time_s) const override {
    const Jet time = time_jet(time_s);
    Kinematics result;
    for (int k = 0; k < 3; ++k)
      result = result * shifting(Vector3d::Unit(k), sum_of(waves_[k], options_.position_m, time));
    for (int k = 0; k < 3; ++k)
      result = result * turning(Vector3d::Unit(k), sum_of(waves_[3 + k], options_.rotation_rad, time));
    return result;
  }

 private:
  TremorOptions options_;
  std::array<Waves, 6> waves_;
};

// The way since the leg's start.
Jet way_of(double speed_mps, double acceleration_mps2, double since_s) {
  if (acceleration_mps2 < 0 && since_s > speed_mps / -acceleration_mps2)
    return {speed_mps * speed_mps / (-2 * acceleration_mps2), 0, 0};
  return {speed_mps * since_s + acceleration_mps2 * since_s * since_s / 2,
          speed_mps + acceleration_mps2 * since_s, acceleration_mps2};
}

// From the origin along x, by a way in which the curvature grows evenly.
Kinematics along_clothoid(double curvature_pm, double sharpness_pm2, const Jet& way) {
  const Jet heading = curvature_pm * way + 0.5 * sharpness_pm2 * way * way;
  const auto ahead = [](double angle_rad) { return Vector3d(std::cos(angle_rad), std::sin(angle_rad), 0); };
  const auto shift = [&](int axis) {
    return boost::math::quadrature::gauss<double, 30>::integrate(
        [&](double s) { return ahead(curvature_pm * s + 0.5 * sharpness_pm2 * s * s)[axis]; }, 0.0,
        way.value);
  };
  Kinematics result = turning(Vector3d::UnitZ(), heading);
  const Vector3d forward = ahead(heading.value), left(-forward.y(), forward.x(), 0);
  result.pose.translation = {shift(0), shift(1), 0};
  result.velocity_mps = way.rate * forward;
  result.acceleration_mps2 = way.acceleration * forward + way.rate * heading.rate * left;
  return result;
}

class Drive final : public Motion::Curve {
 public:
  explicit Drive(const DriveOptions& options) {
    const Eigen::Vector3d origin(options.ahead_m, 0, options.height_m);
    axle_from_body_ = {Eigen::Quaterniond::Identity(), origin};
    if (options.optical) axle_from_body_.rotation = camera_from_body_axes().rotation.conjugate();
    const auto curvature_pm = [&](const DriveLeg& of) {
      return std::tan(of.steer_rad) / options.wheelbase_m;
    };
    Leg leg{options.begins_s,
            {exp_so3(options.heading_rad * Vector3d::UnitZ()), {options.start_m.x(), options.start_m.y(), 0}},
            options.speed_mps,
            0,
            options.legs.empty() ? 0 : curvature_pm(options.legs.front())};
    legs_.push_back(leg);  // before the first
    for (const DriveLeg& next : options.legs) {
      const double own_pm = curvature_pm(next);
      const double steers_s = own_pm == leg.curvature_pm ? 0 : std::min(options.steering_s, next.duration_s);
      const double ends_s = leg.begins_s + next.duration_s;
      leg.acceleration_mps2 = next.acceleration_mps2;
      if (const double way_m = way_of(leg.speed_mps, leg.acceleration_mps2, steers_s).value; way_m > 0) {
        leg.sharpness_pm2 = (own_pm - leg.curvature_pm) / way_m;
        add(leg, steers_s);
      }
      leg.curvature_pm = own_pm;
      leg.sharpness_pm2 = 0;
      add(leg, ends_s - leg.begins_s);
    }
    leg.acceleration_mps2 = 0;
    legs_.push_back(leg);
  }

  Kinematics kinematics(double time_s) const override {
    const auto next = std::upper_bound(legs_.begin() + 1, legs_.end(), time_s,
                                       [](double time, const Leg& leg) { return time < leg.begins_s; });
    const Leg& leg = *(next - 1);
    const double since_s = time_s - leg.begins_s;
    return along(leg, way_of(leg.speed_mps, leg.acceleration_mps2, since_s)) * at_rest(axle_from_body_);
  }

 private:
  struct Leg {
    double begins_s;
    Pose world_from_axle;
    double speed_mps, acceleration_mps2;
    double curvature_pm, sharpness_pm2 = 0;  // at its begin, and what a metre adds
  };

  // And puts `leg` to its end.
  void add(Leg& leg, double duration_s) {
    legs_.push_back(leg);
    const Jet way = way_of(leg.speed_mps, leg.acceleration_mps2, duration_s);
    leg.world_from_axle = along(leg, way).pose;
    leg.begins_s += duration_s;
    leg.speed_mps = way.rate;
  }

  static Kinematics along(const Leg& leg, const Jet& way) {
    constexpr double kStraight_pm = 1e-9;
    const Kinematics start = at_rest(leg.world_from_axle);
    if (leg.sharpness_pm2 != 0) return start * along_clothoid(leg.curvature_pm, leg.sharpness_pm2, way);
    if (std::abs(leg.curvature_pm) < kStraight_pm) return start * shifting(Vector3d::UnitX(), way);
    const Vector3d centre(0, 1 / leg.curvature_pm, 0);
    return start * at_rest({Eigen::Quaterniond::Identity(), centre}) *
           turning(Vector3d::UnitZ(), leg.curvature_pm * way) *
           at_rest({Eigen::Quaterniond::Identity(), -centre});
  }

  Pose axle_from_body_;
  std::vector<Leg> legs_;  // the first counts before its start, too
};

}  // namespace

Motion tremor_motion(const TremorOptions& options) {
  return Motion(std::make_shared<Tremor>(options));
}

Motion drive_motion(const DriveOptions& options) {
  return Motion(std::make_shared<Drive>(options));
}

}  // namespace uniquadric
