#include "estimator/upright/upright_filter.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/seconds.h"

namespace uniquadric {
namespace {

constexpr double kStartYaw = 0.3;         // [rad], sigma of the way that a body was first seen to go
constexpr double kStartSpeedShare = 0.3;  // of the speed, its sigma then
constexpr double kRestSpeed = 0.5;        // [m/s]: slower is not known to go anywhere
constexpr double kReach = 0.35;           // [rad] about the expected yaw, that sides are looked for in
constexpr double kSlip = 0.3;             // of the acceleration, across the body
constexpr double kLeastSize = 0.1;        // [m]
constexpr double kNarrow = 0.01;          // sigmas between two bounds that are one measurement
constexpr double kFarSigmas = 5;          // beyond a bound, where the other one does not count
constexpr int kPatience = 3;              // scans in which an end is not where it was expected

double angle_between(double to, double from) {
  return std::remainder(to - from, 2 * std::numbers::pi);
}

// What was seen of a body in one scan.
SeenSize seen_size(const UprightSight& sight, double yaw_rad, double speed_mps) {
  const auto ends = box_ends(sight, yaw_rad);
  SeenSize seen;
  for (int axis = 0; axis < 2; ++axis) {
    const BoxEnd &back = ends[2 * axis], &front = ends[2 * axis + 1];
    seen.size_m[axis] = front.position_m + back.position_m;
    seen.sigma_m[axis] = std::hypot(front.sigma_m, back.sigma_m);
    seen.beyond_m[axis] = front.beyond_m + back.beyond_m;
    seen.is_whole[axis] = !front.is_bound && !back.is_bound;
  }
  seen.size_m.z() = sight.height_m;
  seen.sigma_m.z() = sight.height_sigma_m;
  seen.beyond_m.z() = sight.row_gap_m;
  seen.is_whole[2] = true;
  seen.speed_mps = speed_mps;
  return seen;
}

// Of a thing of any kind: as large as what is seen, or larger by as much.
SizeBelief any_size(const SeenSize& seen) {
  const double most_m = seen.size_m.maxCoeff();
  const double longer = seen.size_m.x() < seen.size_m.y() ? 1 : 0;  // its length is its longer side
  return {seen.size_m.cwiseMax(kLeastSize), Eigen::Vector3d::Constant(most_m), longer};
}

// Of the logarithm of the chance that a number whose mean is 0 lies between two, by its mean: the first
// derivative, and the second one's negative. Far from both, and where they are one, those of a measurement.
struct Slopes {
  double first = 0, second = 0;
};
Slopes slopes_between(double low, double high, double sigma) {
  const double a = low / sigma, b = high / sigma;
  const auto measured = [&](double at) { return Slopes{at / sigma, 1 / (sigma * sigma)}; };
  if (b - a < kNarrow) return measured((a + b) / 2);
  if (a > kFarSigmas) return measured(a);
  if (b < -kFarSigmas) return measured(b);
  const auto density = [](double x) { return std::exp(-x * x / 2) / std::sqrt(2 * std::numbers::pi); };
  const auto below = [](double x) { return std::erfc(-x / std::numbers::sqrt2) / 2; };
  const double chance = below(b) - below(a);
  const double first = (density(a) - density(b)) / chance;
  const double second = first * first - (a * density(a) - b * density(b)) / chance;
  return {first / sigma, second / (sigma * sigma)};
}

UprightMatrix noise_over(double t, double yaw_rad, const UprightBoxOptions& o) {
  const Eigen::Vector2d ahead(std::cos(yaw_rad), std::sin(yaw_rad));
  UprightMatrix noise = UprightMatrix::Zero();
  UprightVector along = UprightVector::Zero(), across = along, turn = along;
  along.head<2>() = ahead * t * t / 2;
  along[kSpeed] = t;
  across.head<2>() = kSlip * t * t / 2 * Eigen::Vector2d(-ahead.y(), ahead.x());
  turn[kYaw] = t * t / 2;
  turn[kYawRate] = t;
  const double a = o.acceleration_mps2 * o.acceleration_mps2;
  noise += a * (along * along.transpose() + across * across.transpose());
  noise += std::pow(o.turn_acceleration_radps2, 2) * turn * turn.transpose();
  return noise;
}

}  // namespace

SizeBelief UprightFilter::expected_size(const UprightSight& sight, const UprightState& state) const {
  const SeenSize seen = seen_size(sight, state.mean[kYaw], state.mean[kSpeed]);
  return options_.street_sizes ? street_size(seen) : any_size(seen);
}

// Sides tell the yaw up to a quarter turn: the way that fits a street user better is along the length.
SizeBelief UprightFilter::turn_along_length(const UprightSight& sight, UprightState& state) const {
  UprightState across = state;
  across.mean[kYaw] += std::numbers::pi / 2;
  const SizeBelief size = expected_size(sight, state), turned = expected_size(sight, across);
  if (!(turned.misfit < size.misfit)) return size;
  state = across;
  return turned;
}

void UprightFilter::start(const UprightSight& sight, const Eigen::Vector2d& velocity_mps) {
  Step& step = steps_.emplace_back();
  UprightState& s = step.now;
  s.frame = sight.frame;
  s.stamp_ns = sight.stamp_ns;
  s.mean[kSpeed] = velocity_mps.norm();
  double yaw_sigma = kStartYaw;
  const bool rests = s.mean[kSpeed] < kRestSpeed;  // where it would go, its sides alone tell
  s.mean[kYaw] = rests ? 0 : std::atan2(velocity_mps.y(), velocity_mps.x());
  const double reach_rad = rests ? std::numbers::pi / 4 : 2 * kReach;
  if (const auto yaw = options_.shape_yaw ? seen_yaw(sight, s.mean[kYaw], reach_rad) : std::nullopt) {
    s.mean[kYaw] = yaw->yaw_rad;
    yaw_sigma = std::min(yaw_sigma, yaw->sigma_rad);
  }
  const SizeBelief size = rests ? turn_along_length(sight, s) : expected_size(sight, s);
  s.mean.tail<3>() = size.size_m;
  s.mean.head<2>() = sight.points.rowwise().mean();
  UprightVector sigmas;
  sigmas << size.size_m.norm(), size.size_m.norm(), yaw_sigma, kStartSpeedShare * s.mean[kSpeed], kStartYaw,
      size.sigma_m;
  s.covariance = sigmas.cwiseAbs2().asDiagonal();
  see(sight, s);
  step.predicted = s.mean;
  step.predicted_covariance = s.covariance;
}

UprightFilter::Step UprightFilter::gone_on(const UprightState& from, std::int64_t frame,
                                           std::int64_t stamp_ns) const {
  const double t = seconds(from.stamp_ns, stamp_ns);
  Step step;
  UprightState& s = step.now;
  s = from;
  s.frame = frame;
  s.stamp_ns = stamp_ns;
  s.is_seen = false;
  const double middle_rad = from.mean[kYaw] + from.mean[kYawRate] * t / 2;
  const Eigen::Vector2d ahead(std::cos(middle_rad), std::sin(middle_rad)), left(-ahead.y(), ahead.x());
  s.mean.head<2>() += from.mean[kSpeed] * t * ahead;
  s.mean[kYaw] += from.mean[kYawRate] * t;
  step.transition.block<2, 1>(kX, kYaw) = from.mean[kSpeed] * t * left;
  step.transition.block<2, 1>(kX, kSpeed) = t * ahead;
  step.transition.block<2, 1>(kX, kYawRate) = from.mean[kSpeed] * t * t / 2 * left;
  step.transition(kYaw, kYawRate) = t;
  s.covariance =
      step.transition * from.covariance * step.transition.transpose() + noise_over(t, middle_rad, options_);
  step.predicted = s.mean;
  step.predicted_covariance = s.covariance;
  return step;
}

void UprightFilter::step(std::int64_t frame, std::int64_t stamp_ns, const UprightSight* sight) {
  Step step = gone_on(steps_.back().now, frame, stamp_ns);
  if (sight) see(*sight, step.now);
  steps_.push_back(step);
}

std::vector<UprightState> UprightFilter::before(const UprightState& first,
                                                const std::vector<UprightFrame>& frames) {
  std::vector<UprightState> states = {first};
  for (auto frame = frames.rbegin(); frame != frames.rend(); ++frame) {
    states.push_back(gone_on(states.back(), frame->frame, frame->stamp_ns).now);
    if (frame->sight) see(*frame->sight, states.back());
  }
  states.erase(states.begin());
  std::reverse(states.begin(), states.end());
  return states;
}

// One number that was measured, where it is not far from what is expected.
bool UprightFilter::measure(const UprightVector& row, const Seen& seen, UprightState& state) const {
  const UprightVector by_row = state.covariance * row;
  const double variance = row.dot(by_row) + seen.sigma * seen.sigma;
  const double off = std::max({0.0, seen.low, -seen.high});
  if (off * off > options_.gate_sigmas * options_.gate_sigmas * variance) return false;
  const Slopes slopes = slopes_between(seen.low, seen.high, std::sqrt(variance));
  state.mean += by_row * slopes.first;
  state.covariance -= slopes.second * by_row * by_row.transpose();
  state.mean.tail<3>() = state.mean.tail<3>().cwiseMax(kLeastSize);
  return true;
}

void UprightFilter::see(const UprightSight& sight, UprightState& state) {
  state.is_seen = true;
  state.bottom_m = sight.bottom_m;
  if (const auto yaw = options_.shape_yaw ? seen_yaw(sight, state.mean[kYaw], kReach) : std::nullopt) {
    const double off_rad = angle_between(yaw->yaw_rad, state.mean[kYaw]);
    measure(UprightVector::Unit(kYaw), {off_rad, off_rad, yaw->sigma_rad}, state);
  }
  const double yaw_sigma = std::sqrt(state.covariance(kYaw, kYaw));
  const auto ends = box_ends(sight, state.mean[kYaw]);
  for (int side = 0; side < 4; ++side) {
    const BoxEnd& end = ends[side];
    const int size = side < 2 ? kLength : kWidth, other = side < 2 ? kWidth : kLength;
    UprightVector row = UprightVector::Zero();
    row.head<2>() = end.direction;
    row[size] = 0.5;
    const double innovation = end.position_m - row.dot(state.mean);
    if (end.is_bound && innovation < 0) continue;
    // a corner of a box that is turned otherwise stands out
    const double sigma = std::hypot(end.sigma_m, yaw_sigma * state.mean[other] / 2);
    const Seen seen{innovation, innovation + (end.is_bound ? 0 : end.beyond_m), sigma};
    if (measure(row, seen, state)) {
      scans_off_[side] = 0;
    } else if (++scans_off_[side] >= kPatience) {
      doubt(row, seen.low > 0 ? seen.low : seen.high, state);
      measure(row, seen, state);
    }
  }
  const double higher_m = sight.height_m - state.mean[kHeight];
  measure(UprightVector::Unit(kHeight), {higher_m, higher_m + sight.row_gap_m, sight.height_sigma_m}, state);
}

// An end that was elsewhere for some scans: place and size, which say where it should be, may be as wrong.
void UprightFilter::doubt(const UprightVector& row, double innovation, UprightState& state) {
  state.covariance += innovation * innovation * row * row.transpose();
  state.covariance.diagonal() += (innovation * row).cwiseAbs2();
}

std::vector<UprightState> UprightFilter::causal() const {
  std::vector<UprightState> states;
  for (const Step& step : steps_) states.push_back(step.now);
  return states;
}

UprightState UprightFilter::looked_back(std::size_t step, const UprightState& later) const {
  const Step& next = steps_[step + 1];
  UprightState state = steps_[step].now;
  const UprightMatrix gain =
      next.predicted_covariance.ldlt().solve(next.transition * state.covariance).transpose();
  state.mean += gain * (later.mean - next.predicted);
  state.covariance += gain * (later.covariance - next.predicted_covariance) * gain.transpose();
  state.mean.tail<3>() = state.mean.tail<3>().cwiseMax(kLeastSize);
  return state;
}

std::vector<UprightState> UprightFilter::smoothed(std::int64_t lag_ns) const {
  std::vector<UprightState> states = causal();
  const std::size_t last = steps_.size() - 1;
  for (std::size_t k = 0, end = 0; k <= last; ++k) {
    while (end < last && steps_[end].now.stamp_ns < steps_[k].now.stamp_ns + lag_ns) ++end;
    if (end == last) {  // from here on all is known by the same last step
      for (std::size_t i = last; i-- > k;) states[i] = looked_back(i, states[i + 1]);
      break;
    }
    UprightState later = steps_[end].now;
    for (std::size_t i = end; i-- > k;) later = looked_back(i, later);
    states[k] = later;
  }
  return states;
}

}  // namespace uniquadric
