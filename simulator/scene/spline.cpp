#include "simulator/scene/spline.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <unsupported/Eigen/NonLinearOptimization>
#include <unsupported/Eigen/Splines>

#include "core/base/error.h"
#include "simulator/scene/curve.h"

namespace uniquadric {
namespace {

using Basis = Eigen::Spline<double, 1, 3>;  // for its basis functions alone
constexpr int kDegree = 3;
constexpr double kStep = 1e-14;  // relative: the solver stops when its steps are rounding
constexpr double kNoTurn_rad = 1e-9;
constexpr double kSolved_rad = 1e-10;  // what then must be left of the way-points' turns

constexpr std::size_t kMostWaypoints = 500;  // ours: all legs' turns are solved for at once

constexpr std::size_t kMostRecordedSteps = 1'000'000;  // ours: 100 MiB; a gap may make many

/// The four basis functions that are not zero at one time, the first belonging to control pose `first`.
struct Weights {
  Eigen::Index first;
  Eigen::Array4d value;
};

class Spline final : public Motion::Curve {
 public:
  explicit Spline(const std::vector<Waypoint>& waypoints);
  /// Through the neighbourhood of poses at even times: they are the controls.
  Spline(const std::vector<Pose>& controls, double begin_s, double step_s);
  Pose at(double time_s) const override;
  Kinematics kinematics(double time_s) const override;

 private:
  Weights weights(double time_s) const;
  Eigen::Quaterniond rotation(const Weights& w) const;
  void solve_positions(const std::vector<Waypoint>& waypoints);
  void solve_rotations(const std::vector<Waypoint>& waypoints);
  void set_turns(const Eigen::VectorXd& inner);

  double begin_s_, end_s_;
  Basis::KnotVectorType knots_s_;
  Eigen::MatrixX3d positions_m_;               ///< a control position a row
  Eigen::Matrix3Xd turns_;                     ///< column j: rotation vector from control j - 1 to j
  std::vector<Eigen::Quaterniond> rotations_;  ///< of the controls: the product of all turns up to each
};

Spline::Spline(const std::vector<Waypoint>& waypoints)
    : begin_s_(waypoints.front().time_s), end_s_(waypoints.back().time_s) {
  const auto n = static_cast<Eigen::Index>(waypoints.size());
  knots_s_.resize(n + 2 * kDegree);
  for (Eigen::Index i = 0; i < knots_s_.size(); ++i)
    knots_s_[i] = waypoints[std::clamp<Eigen::Index>(i - kDegree, 0, n - 1)].time_s;
  solve_positions(waypoints);
  solve_rotations(waypoints);
}

// The end poses stand once more outside, so that the curve runs as long as the poses.
Spline::Spline(const std::vector<Pose>& controls, double begin_s, double step_s)
    : begin_s_(begin_s), end_s_(begin_s + step_s * static_cast<double>(controls.size() - 1)) {
  const auto n = static_cast<Eigen::Index>(controls.size()) + 2;
  knots_s_.resize(n + kDegree + 1);
  for (Eigen::Index i = 0; i < knots_s_.size(); ++i)
    knots_s_[i] = begin_s + step_s * static_cast<double>(i - kDegree);
  positions_m_.resize(n, 3);
  turns_ = Eigen::Matrix3Xd::Zero(3, n);
  for (Eigen::Index j = 0; j < n; ++j) {
    const Pose& pose = controls[static_cast<std::size_t>(std::clamp<Eigen::Index>(j - 1, 0, n - 3))];
    positions_m_.row(j) = pose.translation.transpose();
    rotations_.push_back(pose.rotation);
    if (j > 0) turns_.col(j) = log_so3(rotations_[j - 1].conjugate() * rotations_[j]);
  }
}

Weights Spline::weights(double time_s) const {
  const Eigen::Index span = Basis::Span(time_s, kDegree, knots_s_);
  return {span - kDegree, Basis::BasisFunctions(time_s, kDegree, knots_s_).transpose()};
}

// n way-points and rest at the ends, where the outer two controls coincide, make n + 2 equations.
void Spline::solve_positions(const std::vector<Waypoint>& waypoints) {
  const auto n = static_cast<Eigen::Index>(waypoints.size());
  Eigen::MatrixXd conditions = Eigen::MatrixXd::Zero(n + 2, n + 2);
  Eigen::MatrixX3d wanted = Eigen::MatrixX3d::Zero(n + 2, 3);
  conditions.topLeftCorner<1, 2>() << -1, 1;
  conditions.bottomRightCorner<1, 2>() << -1, 1;
  for (Eigen::Index k = 0; k < n; ++k) {
    const Weights w = weights(waypoints[k].time_s);
    conditions.block<1, 4>(k + 1, w.first) = w.value.matrix().transpose();
    wanted.row(k + 1) = waypoints[k].world_from_body.translation.transpose();
  }
  positions_m_ = conditions.partialPivLu().solve(wanted);
}

/// How far the curve's rotations are from the way-points', as the solver asks for it.
template <typename Residual>
struct Equations {
  using Scalar = double;
  Residual residual;
  int operator()(const Eigen::VectorXd& unknown, Eigen::VectorXd& result) const {
    result = residual(unknown);
    return 0;
  }
};

// Rotations do not add, so these equations are not linear: one turn for each leg between way-points is
// unknown. Turns, not control rotations, because a turn between controls may well exceed pi where the legs
// differ much in length.
void Spline::solve_rotations(const std::vector<Waypoint>& waypoints) {
  const auto n = static_cast<Eigen::Index>(waypoints.size());
  rotations_.assign(static_cast<std::size_t>(n) + 2, waypoints.front().world_from_body.rotation);
  Eigen::VectorXd turns(3 * (n - 1));
  for (Eigen::Index k = 1; k < n; ++k)
    turns.segment<3>(3 * (k - 1)) = log_so3(waypoints[k - 1].world_from_body.rotation.conjugate() *
                                            waypoints[k].world_from_body.rotation);
  // differences over a share of what is rounding alone would be none
  turns = (turns.array().abs() < kNoTurn_rad).select(0, turns);
  const auto misses = [&](const Eigen::VectorXd& unknown) {
    set_turns(unknown);
    Eigen::VectorXd miss(unknown.size());
    for (Eigen::Index k = 1; k < n; ++k)
      miss.segment<3>(3 * (k - 1)) =
          log_so3(rotation(weights(waypoints[k].time_s)).conjugate() * waypoints[k].world_from_body.rotation);
    return miss;
  };
  Equations<decltype(misses)> equations{misses};
  Eigen::HybridNonLinearSolver<decltype(equations)> solver(equations);
  solver.parameters.xtol = kStep;
  solver.solveNumericalDiff(turns);
  if (!(misses(turns).lpNorm<Eigen::Infinity>() < kSolved_rad))
    throw InputError("no smooth curve turns through these way-points: add some between");
}

// At rest the outer two controls coincide: their turns are zero.
void Spline::set_turns(const Eigen::VectorXd& inner) {
  turns_ = Eigen::Matrix3Xd::Zero(3, inner.size() / 3 + 3);
  for (Eigen::Index j = 2; j < turns_.cols() - 1; ++j) turns_.col(j) = inner.segment<3>(3 * (j - 2));
  for (Eigen::Index j = 1; j < turns_.cols(); ++j)
    rotations_[j] = (rotations_[j - 1] * exp_so3(turns_.col(j))).normalized();
}

// R_0 exp(B_1 w_1) exp(B_2 w_2) exp(B_3 w_3) with B_j the sum of the basis functions from j on.
Eigen::Quaterniond Spline::rotation(const Weights& w) const {
  Eigen::Quaterniond result = rotations_[w.first];
  for (Eigen::Index j = 1; j <= kDegree; ++j)
    result = result * exp_so3(w.value.tail(kDegree + 1 - j).sum() * turns_.col(w.first + j));
  return result.normalized();
}

Pose Spline::at(double time_s) const {
  const Weights w = weights(std::clamp(time_s, begin_s_, end_s_));
  return {rotation(w), positions_m_.middleRows<4>(w.first).transpose() * w.value.matrix()};
}

Kinematics Spline::kinematics(double time_s) const {
  if (time_s < begin_s_ || time_s > end_s_) return at_rest(at(time_s));
  const Eigen::Index first = Basis::Span(time_s, kDegree, knots_s_) - kDegree;
  const Eigen::Array<double, 3, kDegree + 1> basis =  // values, first and second derivatives
      Basis::BasisFunctionDerivatives(time_s, 2, kDegree, knots_s_);
  Kinematics result = at_rest({rotations_[first], Eigen::Vector3d::Zero()});
  for (Eigen::Index j = 1; j <= kDegree; ++j) {
    const Eigen::Array3d share = basis.rightCols(kDegree + 1 - j).rowwise().sum();
    result = result * turning(turns_.col(first + j), {share[0], share[1], share[2]});
  }
  result.pose.rotation.normalize();
  const Eigen::Matrix3d positions =
      positions_m_.middleRows<4>(first).transpose() * basis.matrix().transpose();
  result.pose.translation = positions.col(0);
  result.velocity_mps = positions.col(1);
  result.acceleration_mps2 = positions.col(2);
  return result;
}

void check(const std::vector<Waypoint>& waypoints) {
  if (waypoints.size() < 2) throw InputError("a spline needs at least 2 way-points");
  if (waypoints.size() > kMostWaypoints)
    throw InputError(fmt::format("a spline has {} way-points, at most {}", waypoints.size(), kMostWaypoints));
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

Pose between(const Waypoint& a, const Waypoint& b, double time_s) {
  const double share = (time_s - a.time_s) / (b.time_s - a.time_s);
  const Pose &from = a.world_from_body, &to = b.world_from_body;
  return {from.rotation.slerp(share, to.rotation),
          from.translation + share * (to.translation - from.translation)};
}

double median_step_s(const std::vector<Waypoint>& record) {
  std::vector<double> steps;
  for (std::size_t k = 1; k < record.size(); ++k) steps.push_back(record[k].time_s - record[k - 1].time_s);
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle;
}

}  // namespace

Motion recorded_motion(std::vector<Waypoint> record) {
  if (record.size() < 2) throw InputError("a recorded motion needs at least 2 poses");
  for (std::size_t k = 1; k < record.size(); ++k)
    if (!(record[k].time_s > record[k - 1].time_s))
      throw InputError(fmt::format("pose {}: its time does not follow the one before", k));
  const double begin_s = record.front().time_s, length_s = record.back().time_s - begin_s;
  const auto steps = static_cast<std::size_t>(std::max(1.0, std::round(length_s / median_step_s(record))));
  if (steps > kMostRecordedSteps)
    throw InputError(fmt::format("a recorded motion has {} steps of the median length, at most {}", steps,
                                 kMostRecordedSteps));
  const double step_s = length_s / static_cast<double>(steps);
  std::vector<Pose> controls;
  std::size_t after = 1;
  for (std::size_t i = 0; i <= steps; ++i) {
    const double time_s = begin_s + step_s * static_cast<double>(i);
    while (after + 1 < record.size() && record[after].time_s < time_s) ++after;
    controls.push_back(between(record[after - 1], record[after], std::min(time_s, record.back().time_s)));
  }
  return Motion(std::make_shared<Spline>(controls, begin_s, step_s));
}

Motion spline_motion(const std::vector<Waypoint>& waypoints) {
  check(waypoints);
  return Motion(std::make_shared<Spline>(waypoints));
}

}  // namespace uniquadric
