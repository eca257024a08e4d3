#include "estimator/window/trajectory_smoother.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/base/quantile.h"

namespace uniquadric {
namespace {

using Matrix9d = Eigen::Matrix<double, 9, 9>;
using State = Eigen::Matrix<double, 9, 1>;  // offset, velocity, acceleration in units of the usual time step

// Density of the jerk's noise that is tried, against the variance of a measurement: from a body at rest to
// one whose frames do not know of each other.
constexpr double kLeastJerk = 1e-10, kMostJerk = 1e4;
constexpr double kFirstJerk = 1e-2;
constexpr double kLoose = 1e-2;  // information that makes the first velocity and acceleration definite
constexpr int kLeastSamples = 5;
constexpr double kSettled = 1e-4;                // [m], [rad] by which the last round moved any pose
constexpr int kMostRounds = 30, kFewRounds = 3;  // from the start, and where a trajectory goes on
// Of a time step, usual ones: its information grows with the fifth power, and drowns all other in rounding.
constexpr double kLeastStep = 0.3;

// One of translation and rotation, linearised about a nominal trajectory.
struct Chain {
  std::vector<double> time_steps;                              // (n - 1) over their mean
  std::vector<Eigen::Vector3d> step;                           // (n - 1) nominal: k + 1 less k
  std::vector<Eigen::Vector3d> measured;                       // (n) less nominal
  std::vector<Eigen::Vector3d> went;                           // (n - 1) measured step less the nominal one
  std::vector<Eigen::Matrix3d> information, step_information;  // (n), (n - 1); zero where nothing is known
};

struct Solution {
  std::vector<State> states;
  std::vector<Eigen::Matrix3d> covariance;  // of the offsets
  double cost = 0;                          // sum of squares, weighted
  double log_determinant = 0;               // of the information of all states
};

Matrix9d for_each_axis(const Eigen::Matrix3d& m) {
  Matrix9d result = Matrix9d::Zero();
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) result.block<3, 3>(3 * i, 3 * j).diagonal().setConstant(m(i, j));
  return result;
}

Eigen::Matrix3d transition(double t) {
  return (Eigen::Matrix3d() << 1, t, t * t / 2, 0, 1, t, 0, 0, 1).finished();
}

// Information of a transition that white noise of unit density on the jerk disturbs.
Eigen::Matrix3d transition_information(double t) {
  const double t2 = t * t, t3 = t2 * t, t4 = t3 * t, t5 = t4 * t;
  return (Eigen::Matrix3d() << 720 / t5, -360 / t4, 60 / t3, -360 / t4, 192 / t3, -36 / t2, 60 / t3, -36 / t2,
          9 / t)
      .finished();
}

Eigen::Vector3d lag(const Chain& chain, const std::vector<State>& x, std::size_t k) {
  return x[k + 1].head<3>() - x[k].head<3>() - chain.went[k];
}

State disturbance(const Chain& chain, const std::vector<State>& x, std::size_t k) {
  const Eigen::Matrix3d F = transition(chain.time_steps[k]);
  State e = x[k + 1];
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j) e.segment<3>(3 * i) -= F(i, j) * x[k].segment<3>(3 * j);
  e.head<3>() += chain.step[k];
  return e;
}

double cost_of(const Chain& chain, const std::vector<State>& x, double jerk) {
  double cost = 0;
  for (std::size_t k = 0; k < x.size(); ++k) {
    const Eigen::Vector3d r = x[k].head<3>() - chain.measured[k];
    cost += r.dot(chain.information[k] * r);
    if (k + 1 == x.size()) break;
    const Eigen::Vector3d s = lag(chain, x, k);
    const State e = disturbance(chain, x, k);
    const Eigen::Matrix3d P = transition_information(chain.time_steps[k]) / jerk;
    const Eigen::Map<const Eigen::Matrix3d> by_axis(e.data());  // a row an axis
    cost += s.dot(chain.step_information[k] * s) + by_axis.cwiseProduct(by_axis * P).sum();
  }
  return cost;
}

enum class Covariances { wanted, left };

// Normal equations, block tridiagonal: eliminated forwards, solved backwards (a Kalman smoother by its other
// name).
Solution solve(const Chain& chain, double jerk, Covariances covariances = Covariances::wanted) {
  const std::size_t n = chain.measured.size();
  std::vector<Matrix9d> diagonal(n, Matrix9d::Zero()), next(n, Matrix9d::Zero());
  std::vector<State> right(n, State::Zero());
  diagonal[0].diagonal().tail<6>().setConstant(kLoose);
  for (std::size_t k = 0; k < n; ++k) {
    diagonal[k].topLeftCorner<3, 3>() += chain.information[k];
    right[k].head<3>() += chain.information[k] * chain.measured[k];
    if (k + 1 == n) break;
    const Eigen::Matrix3d F = transition(chain.time_steps[k]);  // of each axis by itself
    const Eigen::Matrix3d P = transition_information(chain.time_steps[k]) / jerk, FtP = F.transpose() * P;
    const Eigen::Matrix3d& W = chain.step_information[k];
    diagonal[k] += for_each_axis(FtP * F);
    diagonal[k + 1] += for_each_axis(P);
    next[k] -= for_each_axis(FtP);
    for (int i = 0; i < 3; ++i) {
      right[k].segment<3>(3 * i) += FtP(i, 0) * chain.step[k];
      right[k + 1].segment<3>(3 * i) -= P(i, 0) * chain.step[k];
    }
    diagonal[k].topLeftCorner<3, 3>() += W;
    diagonal[k + 1].topLeftCorner<3, 3>() += W;
    next[k].topLeftCorner<3, 3>() -= W;
    right[k].head<3>() -= W * chain.went[k];
    right[k + 1].head<3>() += W * chain.went[k];
  }
  Solution solution;
  std::vector<Eigen::LLT<Matrix9d>> factor(n);
  std::vector<Matrix9d> gain(n);
  solution.states.resize(n);
  for (std::size_t k = 0; k < n; ++k) {
    factor[k].compute(diagonal[k]);
    solution.log_determinant += 2 * factor[k].matrixLLT().diagonal().array().log().sum();
    solution.states[k] = factor[k].solve(right[k]);
    if (k + 1 == n) break;
    gain[k] = factor[k].solve(next[k]);
    diagonal[k + 1] -= next[k].transpose() * gain[k];
    right[k + 1] -= next[k].transpose() * solution.states[k];
  }
  for (std::size_t k = n - 1; k-- > 0;) solution.states[k] -= gain[k] * solution.states[k + 1];
  if (covariances == Covariances::wanted) {
    solution.covariance.resize(n);
    Matrix9d covariance;
    for (std::size_t k = n; k-- > 0;) {
      const Matrix9d own = factor[k].solve(Matrix9d::Identity());
      covariance = k + 1 == n ? own : Matrix9d(own + gain[k] * covariance * gain[k].transpose());
      solution.covariance[k] = covariance.topLeftCorner<3, 3>();
    }
  }
  solution.cost = cost_of(chain, solution.states, jerk);
  return solution;
}

double typical_variance(const Chain& chain) {
  double sum = 0;
  int n = 0;
  for (const Eigen::Matrix3d& W : chain.information)
    if (!W.isZero()) sum += std::log(W.trace() / 3), ++n;
  return std::exp(-sum / std::max(1, n));
}

int dimensions(const Chain& chain) {
  int n = 0;
  for (const auto* list : {&chain.information, &chain.step_information})
    for (const Eigen::Matrix3d& W : *list) n += W.isZero() ? 0 : 3;
  return n;
}

// Minus twice the logarithm of how likely the measurements are, with the scale of all noise at its best.
double unlikelihood(const Chain& chain, const Solution& solution, double jerk) {
  const double steps = static_cast<double>(chain.step.size());
  return dimensions(chain) * std::log(solution.cost) + solution.log_determinant + 9 * steps * std::log(jerk);
}

// The first minimum of f on the way from `at` by factors of `step`, or back.
template <typename F>
double descend(double at, double step, const F& f) {
  double value = f(at);
  for (const double factor : {step, 1 / step}) {
    const double start = at;
    for (double next = at * factor; next > kLeastJerk && next < kMostJerk; next *= factor) {
      const double there = f(next);
      if (!(there < value)) break;
      at = next;
      value = there;
    }
    if (at != start) break;
  }
  return at;
}

enum class Part { translation, rotation };

// Whether a sample only tells how the body went on from the one before.
bool goes_on(const std::vector<PoseSample>& samples, std::size_t k) {
  return k > 0 && samples[k].evidence == PoseEvidence::relative &&
         (samples[k - 1].evidence == PoseEvidence::relative ||
          samples[k - 1].evidence == PoseEvidence::absolute);
}

Eigen::Matrix3d covariance_of(const PoseSample& sample, Part part, const TrajectorySmootherOptions& o) {
  const Eigen::Matrix3d R = sample.world_from_object.rotation.toRotationMatrix();
  const Eigen::Matrix3d own = part == Part::translation ? sample.covariance.topLeftCorner<3, 3>()
                                                        : sample.covariance.bottomRightCorner<3, 3>();
  const double least = part == Part::translation ? o.least_translation_sigma_m : o.least_rotation_sigma_rad;
  return R * own * R.transpose() + least * least * Eigen::Matrix3d::Identity();
}

// Of each sample, in how many frames in a row the body went on: all of these are off alike.
std::vector<int> frames_that_go_on(const std::vector<PoseSample>& samples) {
  std::vector<int> frames(samples.size(), 1);
  const auto is_one_more = [&](std::size_t k) { return goes_on(samples, k - 1) && goes_on(samples, k); };
  for (std::size_t k = 1; k < samples.size(); ++k)
    if (is_one_more(k)) frames[k] = frames[k - 1] + 1;
  for (std::size_t k = samples.size(); k-- > 1;)
    if (is_one_more(k)) frames[k - 1] = frames[k];
  return frames;
}

// What a sample, `off` the nominal pose, says of where the body is. A body that goes on may
// have drifted: its samples count as one guess.
Eigen::Matrix3d place_information(const PoseSample& sample, int frames_alike, Part part,
                                  const Eigen::Vector3d& off, const TrajectorySmootherOptions& o) {
  if (sample.evidence == PoseEvidence::none) return Eigen::Matrix3d::Zero();
  Eigen::Matrix3d covariance = covariance_of(sample, part, o);
  const double guess = part == Part::translation ? o.guess_sigma_m : o.guess_sigma_rad;
  if (sample.evidence != PoseEvidence::absolute) covariance.diagonal().array() += guess * guess;
  covariance *= frames_alike;
  if (part == Part::translation) return covariance.inverse();
  // about the axis of a body of revolution the two may be any turn apart, that is not small
  const Eigen::Matrix3d J = inverse_right_jacobian_so3(off);
  return J.transpose() * covariance.inverse() * J;
}

Eigen::Matrix3d step_information(const std::vector<PoseSample>& samples, std::size_t k, Part part,
                                 const TrajectorySmootherOptions& o) {
  if (!goes_on(samples, k + 1)) return Eigen::Matrix3d::Zero();
  return (covariance_of(samples[k], part, o) + covariance_of(samples[k + 1], part, o)).inverse();
}

Eigen::Vector3d difference(const Pose& a, const Pose& b, Part part) {
  return part == Part::translation ? Eigen::Vector3d(a.translation - b.translation)
                                   : log_so3(a.rotation * b.rotation.inverse());
}

void move(Pose& pose, const Eigen::Vector3d& by, Part part) {
  if (part == Part::translation)
    pose.translation += by;
  else
    pose.rotation = (exp_so3(by) * pose.rotation).normalized();
}

double usual_step_ns(const std::vector<PoseSample>& samples) {
  std::vector<std::int64_t> steps;
  for (std::size_t k = 1; k < samples.size(); ++k)
    steps.push_back(samples[k].stamp_ns - samples[k - 1].stamp_ns);
  return static_cast<double>(upper_median(std::move(steps)));
}

Chain linearise(const std::vector<PoseSample>& samples, const std::vector<Pose>& nominal, Part part,
                const TrajectorySmootherOptions& options) {
  const std::size_t n = samples.size();
  const double usual_ns = usual_step_ns(samples);
  const std::vector<int> frames_alike = frames_that_go_on(samples);
  Chain chain;
  for (std::size_t k = 0; k < n; ++k) {
    chain.measured.push_back(difference(samples[k].world_from_object, nominal[k], part));
    chain.information.push_back(
        place_information(samples[k], frames_alike[k], part, chain.measured.back(), options));
    if (k + 1 == n) break;
    const PoseSample& next = samples[k + 1];
    const double step = static_cast<double>(next.stamp_ns - samples[k].stamp_ns) / usual_ns;
    chain.time_steps.push_back(std::max(step, kLeastStep));
    chain.step.push_back(difference(nominal[k + 1], nominal[k], part));
    chain.went.push_back(difference(next.world_from_object, samples[k].world_from_object, part) -
                         chain.step.back());
    chain.step_information.push_back(step_information(samples, k, part, options));
  }
  return chain;
}

// What lies far off the nominal trajectory counts less (Cauchy).
void weigh(Chain& chain, double scale, double outlier) {
  const auto weight = [&](const Eigen::Vector3d& r, const Eigen::Matrix3d& information) {
    return 1 / (1 + r.dot(information * r) / (3 * scale * outlier * outlier));
  };
  for (std::size_t k = 0; k < chain.measured.size(); ++k)
    chain.information[k] *= weight(chain.measured[k], chain.information[k]);
  for (std::size_t k = 0; k < chain.went.size(); ++k)
    chain.step_information[k] *= weight(chain.went[k], chain.step_information[k]);
}

void smooth(std::vector<PoseSample>& samples, std::vector<Pose>& nominal, Part part,
            const TrajectorySmootherOptions& options, Restlessness* known) {
  double* const known_jerk = known ? &known->jerk[part == Part::translation ? 0 : 1] : nullptr;
  const bool goes_on = known_jerk && *known_jerk > 0;
  std::vector<double> steps = {100.0, 10.0, 3.0};
  if (goes_on) steps = known->is_settled ? std::vector<double>() : std::vector{10.0, 3.0};
  const int rounds = known ? 1 : options.robust_rounds, most_rounds = known ? kFewRounds : kMostRounds;
  double jerk = goes_on ? *known_jerk : kFirstJerk, scale = 1;
  Solution solution;
  // A turn about an axis of revolution, which nothing holds, is large: the linearisation takes its time.
  double moved = kSettled;
  for (int round = 0; round < rounds || (moved >= kSettled && round < most_rounds); ++round) {
    Chain chain = linearise(samples, nominal, part, options);
    if (round > 0 && !known) weigh(chain, scale, options.outlier);
    const double unit = typical_variance(chain);
    const auto score = [&](double ratio) {
      return unlikelihood(chain, solve(chain, ratio * unit, Covariances::left), ratio);
    };
    if (round < rounds)
      for (const double step : steps) jerk = descend(jerk, step, score);
    solution = solve(chain, jerk * unit);
    if (!(solution.cost > 0)) return;  // a quadric fixed in the world: there is no noise to take off
    scale = solution.cost / dimensions(chain);
    moved = 0;
    for (std::size_t k = 0; k < nominal.size(); ++k) {
      move(nominal[k], solution.states[k].head<3>(), part);
      moved = std::max(moved, solution.states[k].head<3>().norm());
    }
  }
  if (known_jerk) *known_jerk = jerk;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const Eigen::Matrix3d R = nominal[k].rotation.toRotationMatrix();
    const int at = part == Part::translation ? 0 : 3;
    samples[k].covariance.block<3, 3>(at, at) = scale * R.transpose() * solution.covariance[k] * R;
  }
}

// A first trajectory: over frames without evidence on the shortest way.
std::vector<Pose> bridged(const std::vector<PoseSample>& samples) {
  std::vector<Pose> poses;
  for (std::size_t k = 0, before = 0, after = 0; k < samples.size(); ++k) {
    if (samples[k].evidence != PoseEvidence::none) before = k;
    for (after = std::max(after, k); samples[after].evidence == PoseEvidence::none;) ++after;
    const double span = static_cast<double>(samples[after].stamp_ns - samples[before].stamp_ns);
    const double gone = static_cast<double>(samples[k].stamp_ns - samples[before].stamp_ns);
    poses.push_back(before == k ? samples[k].world_from_object
                                : interpolate(samples[before].world_from_object,
                                              samples[after].world_from_object, gone / span));
  }
  return poses;
}

}  // namespace

void smooth_trajectory(std::vector<PoseSample>& samples, const TrajectorySmootherOptions& options,
                       Restlessness* known) {
  const auto has_evidence = [](const PoseSample& s) { return s.evidence != PoseEvidence::none; };
  const auto first = std::find_if(samples.begin(), samples.end(), has_evidence);
  const auto last = std::find_if(samples.rbegin(), samples.rend(), has_evidence).base();
  if (first == samples.end() || std::count_if(first, last, has_evidence) < kLeastSamples) return;
  std::vector<PoseSample> part(first, last);
  std::vector<Pose> nominal = bridged(part);
  for (const Part p : {Part::translation, Part::rotation}) smooth(part, nominal, p, options, known);
  const auto is_finite = [](const Pose& p) {
    return p.translation.allFinite() && p.rotation.coeffs().allFinite();
  };
  if (!std::all_of(nominal.begin(), nominal.end(), is_finite)) return;
  for (std::size_t k = 0; k < part.size(); ++k) part[k].world_from_object = nominal[k];
  std::copy(part.begin(), part.end(), first);
}

}  // namespace uniquadric
