#include "simulator/scene/spline.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <unsupported/Eigen/Splines>

#include "core/base/error.h"
#include "simulator/scene/curve.h"

namespace uniquadric {
namespace {

using Basis = Eigen::Spline<double, 1, 3>;  // for its basis functions alone
constexpr int kDegree = 3;
constexpr int kMaxSteps = 200;
constexpr double kSolved_rad = 1e-13;  // rounding of a product of a dozen quaternions

/// The four basis functions that are not zero at one time, the first belonging to control pose `first`.
struct Weights {
  Eigen::Index first;
  Eigen::Array4d value;
};

class Spline final : public Motion::Curve {
 public:
  explicit Spline(const std::vector<Waypoint>& waypoints);
  Pose at(double time_s) const override;

 private:
  Weights weights(double time_s) const;
  Eigen::Quaterniond rotation(const Weights& w) const;
  void solve_positions(const std::vector<Waypoint>& waypoints);
  void solve_rotations(const std::vector<Waypoint>& waypoints);

  double begin_s_, end_s_;
  Basis::KnotVectorType knots_s_;
  Eigen::PartialPivLU<Eigen::MatrixXd> controls_from_waypoints_;
  std::vector<Eigen::Vector3d> positions_m_;
  std::vector<Eigen::Quaterniond> rotations_;
};

Spline::Spline(const std::vector<Waypoint>& waypoints)
    : begin_s_(waypoints.front().time_s), end_s_(waypoints.back().time_s) {
  const auto n = static_cast<Eigen::Index>(waypoints.size());
  knots_s_.resize(n + 2 * kDegree);
  for (Eigen::Index i = 0; i < knots_s_.size(); ++i)
    knots_s_[i] = waypoints[std::clamp<Eigen::Index>(i - kDegree, 0, n - 1)].time_s;
  // Row 0 and n + 1: the outer two control poses coincide, which is rest at the ends.
  Eigen::MatrixXd conditions = Eigen::MatrixXd::Zero(n + 2, n + 2);
  conditions.topLeftCorner<1, 2>() << -1, 1;
  conditions.bottomRightCorner<1, 2>() << -1, 1;
  for (Eigen::Index k = 0; k < n; ++k) {
    const Weights w = weights(waypoints[k].time_s);
    conditions.block<1, 4>(k + 1, w.first) = w.value.matrix().transpose();
  }
  controls_from_waypoints_.compute(conditions);
  solve_positions(waypoints);
  solve_rotations(waypoints);
}

Weights Spline::weights(double time_s) const {
  const Eigen::Index span = Basis::Span(time_s, kDegree, knots_s_);
  return {span - kDegree, Basis::BasisFunctions(time_s, kDegree, knots_s_).transpose()};
}

void Spline::solve_positions(const std::vector<Waypoint>& waypoints) {
  Eigen::MatrixXd wanted = Eigen::MatrixXd::Zero(knots_s_.size() - kDegree - 1, 3);
  for (std::size_t k = 0; k < waypoints.size(); ++k)
    wanted.row(static_cast<Eigen::Index>(k) + 1) = waypoints[k].world_from_body.translation.transpose();
  const Eigen::MatrixXd controls = controls_from_waypoints_.solve(wanted);
  for (Eigen::Index i = 0; i < controls.rows(); ++i) positions_m_.push_back(controls.row(i));
}

// Rotations do not add: solve the linear problem for the correction again and again. Each round's correction
// shrinks by a factor that grows with the turn between neighbours.
void Spline::solve_rotations(const std::vector<Waypoint>& waypoints) {
  rotations_.push_back(waypoints.front().world_from_body.rotation);
  for (const Waypoint& w : waypoints) rotations_.push_back(w.world_from_body.rotation);
  rotations_.push_back(waypoints.back().world_from_body.rotation);
  for (int step = 0; step < kMaxSteps; ++step) {
    Eigen::MatrixXd miss = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(rotations_.size()), 3);
    for (std::size_t k = 0; k < waypoints.size(); ++k) {
      const Eigen::Quaterniond here = rotation(weights(waypoints[k].time_s));
      miss.row(static_cast<Eigen::Index>(k) + 1) =
          log_so3(here.conjugate() * waypoints[k].world_from_body.rotation);
    }
    if (miss.rowwise().norm().maxCoeff() < kSolved_rad) return;
    const Eigen::MatrixXd correction = controls_from_waypoints_.solve(miss);
    for (Eigen::Index i = 0; i < correction.rows(); ++i)
      rotations_[i] = (rotations_[i] * exp_so3(correction.row(i))).normalized();
  }
  throw InputError("the turns between way-points are too large for a smooth curve: add way-points");
}

// R_0 exp(B_1 w_1) exp(B_2 w_2) exp(B_3 w_3) with B_j the sum of the basis functions from j on.
Eigen::Quaterniond Spline::rotation(const Weights& w) const {
  Eigen::Quaterniond result = rotations_[w.first];
  for (Eigen::Index j = 1; j <= kDegree; ++j) {
    const double cumulative = w.value.tail(kDegree + 1 - j).sum();
    const Eigen::Quaterniond& before = rotations_[w.first + j - 1];
    result = result * exp_so3(cumulative * log_so3(before.conjugate() * rotations_[w.first + j]));
  }
  return result.normalized();
}

Pose Spline::at(double time_s) const {
  const Weights w = weights(std::clamp(time_s, begin_s_, end_s_));
  Pose pose{rotation(w), Eigen::Vector3d::Zero()};
  for (Eigen::Index j = 0; j <= kDegree; ++j) pose.translation += w.value[j] * positions_m_[w.first + j];
  return pose;
}

void check(const std::vector<Waypoint>& waypoints) {
  if (waypoints.size() < 2) throw InputError("a spline needs at least 2 way-points");
  for (std::size_t k = 1; k < waypoints.size(); ++k) {
    const Waypoint &a = waypoints[k - 1], &b = waypoints[k];
    if (!(b.time_s > a.time_s))
      throw InputError(fmt::format("way-point {}: time {} s does not follow {} s", k, b.time_s, a.time_s));
    const double turn = log_so3(a.world_from_body.rotation.conjugate() * b.world_from_body.rotation).norm();
    if (turn > kMaxWaypointTurn_rad)
      throw InputError(fmt::format(
          "way-point {}: turns by {:.0f} deg from the one before, at most {:.0f} (add one between)", k,
          turn * 180 / EIGEN_PI, kMaxWaypointTurn_rad * 180 / EIGEN_PI));
  }
}

}  // namespace

Motion spline_motion(const std::vector<Waypoint>& waypoints) {
  check(waypoints);
  return Motion(std::make_shared<Spline>(waypoints));
}

}  // namespace uniquadric
