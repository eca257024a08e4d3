#include "simulator/scene/toss.h"

#include "simulator/scene/cumulative.h"
#include "simulator/scene/flight.h"

namespace uniquadric {
namespace {

/// Between samples cubics with the samples' poses and velocities, of rotations that of Kim, Kim and Shin (as
/// in spline.h).
class Toss final : public Motion::Curve {
 public:
  Toss(double begins_s, std::vector<Flight::Sample> samples)
      : begins_s_(begins_s), samples_(std::move(samples)) {}
  Kinematics kinematics(double time_s) const override;

 private:
  double begins_s_;
  std::vector<Flight::Sample> samples_;
};

/// How far the velocity of a sample leads in a third of a step: one leg of Bezier's polygon.
Step leg(const Flight::Sample& sample) {
  return {kFlightStep_s / 3 * sample.velocity_mps, kFlightStep_s / 3 * sample.angular_velocity_radps};
}

Kinematics Toss::kinematics(double time_s) const {
  const double steps = (time_s - begins_s_) / kFlightStep_s;
  if (steps < 0) return at_rest(samples_.front().pose);
  if (steps >= static_cast<double>(samples_.size() - 1)) return at_rest(samples_.back().pose);
  const auto k = static_cast<std::size_t>(steps);
  const Pose &from = samples_[k].pose, &to = samples_[k + 1].pose;
  const Step first = leg(samples_[k]), last = leg(samples_[k + 1]);
  const Step middle{
      to.translation - last.shift_m - (from.translation + first.shift_m),
      log_so3((from.rotation * exp_so3(first.turn)).conjugate() * to.rotation * exp_so3(-last.turn))};
  const Jet u{steps - static_cast<double>(k), 1 / kFlightStep_s, 0};
  const Jet u2 = u * u, u3 = u2 * u;
  return cumulative(from, {first, middle, last}, {3 * u + -3 * u2 + u3, 3 * u2 + -2 * u3, u3});
}

}  // namespace

Motion toss_motion(const TossOptions& options, const std::vector<Eigen::Vector3d>& contacts) {
  return Motion(std::make_shared<Toss>(options.begins_s, Flight(options, contacts).simulate()));
}

}  // namespace uniquadric
