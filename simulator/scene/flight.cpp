#include "simulator/scene/flight.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.h"

namespace uniquadric {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kStep_s = kFlightStep_s;
constexpr double kLongest_s = 30;     // ours
constexpr double kBounce_mps = 0.05;  // ours: slower approaches, as in resting, do not bounce
constexpr double kDeepestStart_m = 1e-3;
constexpr double kCorrection = 0.1;  // ours, of the depth in a step

constexpr double kSlow_mps = 0.005, kRest_s = 0.1;  // ours: so slow so long on three points or more is rest
constexpr double kTouching_m = 1e-4;

/// In an impact, whose restitution it returns, the points that arrive stop; else they may come to the plane.
double begin_impact(const Twist& twist, double restitution, std::vector<Contact>& contacts) {
  const auto arrives = [&](const Contact& c) { return twist.at(c.arm_m).z() < c.least_mps; };
  const auto hits = [&](const Contact& c) { return arrives(c) && twist.at(c.arm_m).z() < -kBounce_mps; };
  if (std::ranges::none_of(contacts, hits)) return 0;
  for (Contact& contact : contacts)
    if (arrives(contact)) contact.least_mps = 0;
  return restitution;
}

}  // namespace

Flight::Flight(const TossOptions& options, const std::vector<Vector3d>& points)
    : options_(options), points_(points), pose_(options.start), velocity_mps_(options.velocity_mps) {
  Vector3d semi_axes = Vector3d::Zero();
  double lowest_m = pose_.translation.z();
  for (const Vector3d& p : points) {
    semi_axes = semi_axes.cwiseMax(p.cwiseAbs());
    radius_m_ = std::max(radius_m_, p.norm());
    lowest_m = std::min(lowest_m, (pose_ * p).z());
  }
  if (lowest_m < options.floor_m - kDeepestStart_m)
    throw InputError(fmt::format("starts {:.3g} m below floor_m", options.floor_m - lowest_m));
  const Vector3d squares = semi_axes.cwiseAbs2() / 3;
  inertia_ = Vector3d::Constant(squares.sum()) - squares;
  const Vector3d spin = pose_.rotation.conjugate() * options.angular_velocity_radps;
  momentum_ = pose_.rotation * inertia_.cwiseProduct(spin);
}

Vector3d Flight::angular_velocity() const {
  return pose_.rotation * (pose_.rotation.conjugate() * momentum_).cwiseQuotient(inertia_);
}

Flight::Sample Flight::sample() const {
  return {pose_, velocity_mps_, (pose_.rotation.conjugate() * momentum_).cwiseQuotient(inertia_)};
}

/// The points that can reach the plane in a step.
std::vector<Contact> Flight::contacts(const Twist& twist) const {
  const double reach_m =
      kTouching_m + kStep_s * (twist.velocity_mps.norm() + twist.angular_velocity_radps.norm() * radius_m_);
  const double height_m = pose_.translation.z() - options_.floor_m;
  std::vector<Contact> result;
  if (height_m - radius_m_ > reach_m) return result;
  const Matrix3d R = pose_.rotation.toRotationMatrix();
  for (const Vector3d& p : points_)
    if (const double gap_m = height_m + R.row(2).dot(p); gap_m <= reach_m)
      result.push_back({R * p, gap_m, -std::max(gap_m, 0.0) / kStep_s});
  return result;
}

// The momentum is constant in the step; the velocity half-way makes the turn one of second order.
void Flight::turn() {
  const Eigen::Quaterniond from = pose_.rotation;
  pose_.rotation = exp_so3(kStep_s / 2 * angular_velocity()) * from;
  pose_.rotation = (exp_so3(kStep_s * angular_velocity()) * from).normalized();
}

bool Flight::is_slow(const std::vector<Contact>& contacts) const {
  return std::hypot(velocity_mps_.norm(), angular_velocity().norm() * radius_m_) < kSlow_mps &&
         std::ranges::count_if(contacts, [](const Contact& c) { return c.gap_m < kTouching_m; }) >= 3;
}

void Flight::step() {
  const Vector3d fall_mps = -kStep_s * options_.gravity_mps2 * Vector3d::UnitZ();
  const Twist free{velocity_mps_ + fall_mps, angular_velocity()};
  std::vector<Contact> near = contacts(free);
  const double restitution = begin_impact(free, options_.restitution, near);
  const Matrix3d R = pose_.rotation.toRotationMatrix();
  stop_at_contacts(free, R * inertia_.cwiseInverse().asDiagonal() * R.transpose(), options_.friction, near);
  Vector3d impulse_mps = Vector3d::Zero();
  double depth_m = 0;
  for (const Contact& contact : near) {
    impulse_mps += (1 + restitution) * contact.impulse_mps;
    momentum_ += contact.arm_m.cross((1 + restitution) * contact.impulse_mps);
    depth_m = std::max(depth_m, -contact.gap_m);
  }
  velocity_mps_ = free.velocity_mps + impulse_mps;
  pose_.translation += kStep_s * velocity_mps_ + kCorrection * depth_m * Vector3d::UnitZ();
  if (impulse_mps.z() == 0) pose_.translation -= kStep_s / 2 * fall_mps;  // the parabola
  turn();
  slow_s_ = is_slow(near) ? slow_s_ + kStep_s : 0;
}

std::vector<Flight::Sample> Flight::simulate() {
  std::vector<Sample> samples{sample()};
  for (int k = 1; k * kStep_s <= kLongest_s && slow_s_ < kRest_s; ++k) {
    step();
    samples.push_back(sample());
  }
  samples.back().velocity_mps = samples.back().angular_velocity_radps = Vector3d::Zero();
  return samples;
}

}  // namespace uniquadric
