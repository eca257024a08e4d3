#include "estimator/objects/known_states.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <span>

#include "core/base/quantile.h"
#include "core/base/seconds.h"
#include "estimator/factors/pose_jacobian.h"

namespace uniquadric {
namespace {

// ours: how restless a body is changes slowly, but at first is hardly known
constexpr std::int64_t kAskAgain_ns = 300'000'000;
constexpr std::size_t kFewSamples = 30;
constexpr std::size_t kUsualChanges = 30;  // ours: a second of them
constexpr double kOtherNames_rad = 0.3;    // ours: axes turn by less from one estimate to the next

// A state's pose of the object, whose place in the body is known by now.
PoseSample sample_of(const BodyState& state, const Pose& body_from_object) {
  const Matrix6d moved = adjoint(body_from_object.inverse());
  return {state.stamp_ns, state.world_from_body * body_from_object,
          moved * state.covariance * moved.transpose(), state.evidence};
}

// A state with another shape, whose frame is the body's from here on.
BodyState placed(BodyState state, const Shape& shape, const PoseSample& sample) {
  state.shape = shape;
  state.shape.body_from_object = Pose();
  state.world_from_body = sample.world_from_object;
  state.covariance = sample.covariance;
  return state;
}

// The same place before the camera, which is known to be elsewhere.
void carry(Pose& world_from_body, const Pose& camera_then, const Pose& camera_now) {
  world_from_body = camera_now * camera_then.inverse() * world_from_body;
  world_from_body.rotation.normalize();
}

// The first state of another life, which has a frame of its own.
template <typename Iterator, typename Beginning>
Iterator end_of_life(Iterator begin, Iterator end, const Beginning& beginning) {
  return std::find_if(begin, end, [&](const auto& state) { return beginning(state) != beginning(*begin); });
}

bool was_ever_active(std::span<const RawState> life) {
  return std::ranges::any_of(life, [](const RawState& r) { return r.state.status == ObjectStatus::active; });
}

// Moves a shape towards what it has been found to be, a share 1 - 1/e of the way in `settle_s`: a consumer of
// poses would take the step for a motion. Axes that are named otherwise are taken at once.
void settle(Shape& shape, const Shape& found, double passed_s, double settle_s) {
  const double turn_rad = shape.body_from_object.rotation.angularDistance(found.body_from_object.rotation);
  const Shape before = shape;
  shape = found;
  if (settle_s <= 0 || turn_rad > kOtherNames_rad || before.profile_axis != found.profile_axis) return;
  const double share = -std::expm1(-passed_s / settle_s);
  shape.body_from_object = interpolate(before.body_from_object, found.body_from_object, share);
  shape.semi_axes_m += (1 - share) * (before.semi_axes_m - found.semi_axes_m);
}

double rotation_change(const Pose& a, const Pose& b, const Pose& c) {
  return log_so3((a.rotation.conjugate() * b.rotation).conjugate() * (b.rotation.conjugate() * c.rotation))
      .norm();
}

double translation_change(const Pose& a, const Pose& b, const Pose& c) {
  return (c.translation - 2 * b.translation + a.translation).norm();
}

// By how much the motion changes at a state, over `least`, and over what is usual of the states before it.
class ChangeWatch {
 public:
  ChangeWatch(double least, double sudden) : least_(least), sudden_(sudden) {}
  bool is_sudden(double change) {
    const double usual = usual_.empty() ? change : std::max(least_, quantile(usual_, 0.5));
    usual_.push_back(change);
    if (usual_.size() > kUsualChanges) usual_.erase(usual_.begin());
    return change > sudden_ * usual;
  }

 private:
  double least_, sudden_;
  std::vector<double> usual_;
};

// The stretches of a life, by number: over a jump of its poses (found again, or hit by something) no
// trajectory is smooth.
std::vector<int> stretches_of(std::span<const RawState> life, const TrajectorySmootherOptions& options) {
  ChangeWatch rotation(options.least_rotation_sigma_rad, options.sudden),
      translation(options.least_translation_sigma_m, options.sudden);
  std::vector<int> stretches(life.size(), 0);
  for (std::size_t k = 2; k < life.size(); ++k) {
    const auto pose = [&](std::size_t i) -> const Pose& { return life[i].state.world_from_body; };
    const bool turns = rotation.is_sudden(rotation_change(pose(k - 2), pose(k - 1), pose(k))),
               moves = translation.is_sudden(translation_change(pose(k - 2), pose(k - 1), pose(k)));
    const bool is_echo = stretches[k - 1] != stretches[k - 2];  // of the jump a state before
    stretches[k] = stretches[k - 1] + ((turns || moves) && !is_echo ? 1 : 0);
  }
  return stretches;
}

// Adds the states of a life that was given up at a time.
void add_life(std::span<const RawState> life, std::int64_t lag_ns, std::int64_t given_up_ns,
              const TrajectorySmootherOptions& options, std::vector<BodyState>& states) {
  const std::int64_t history_ns = nanoseconds(options.history_s);
  // With a lag, what comes after a jump says whether it was one.
  const std::vector<int> stretches =
      lag_ns > 0 ? std::vector<int>(life.size(), 0) : stretches_of(life, options);
  Restlessness restlessness;
  std::size_t first = 0, known = 0;
  std::int64_t asked_ns = life.front().state.stamp_ns, shape_ns = asked_ns;
  Shape shape = life.front().state.shape;
  for (std::size_t k = 0; k < life.size(); ++k) {
    const auto& [raw, frame] = life[k];
    const std::int64_t now_ns = raw.stamp_ns + lag_ns;
    if (given_up_ns <= now_ns) return;
    while (life[first].state.stamp_ns < raw.stamp_ns - history_ns || stretches[first] != stretches[k])
      ++first;
    while (known < life.size() && life[known].state.stamp_ns <= now_ns) ++known;
    const BodyState& newest = life[known - 1].state;
    settle(shape, newest.shape, seconds(shape_ns, newest.stamp_ns), options.settle_s);
    shape_ns = newest.stamp_ns;
    std::vector<PoseSample> samples;
    for (std::size_t i = first; i < known && stretches[i] == stretches[k]; ++i)
      samples.push_back(sample_of(life[i].state, shape.body_from_object));
    restlessness.is_settled = raw.stamp_ns - asked_ns < kAskAgain_ns && samples.size() > kFewSamples;
    if (!restlessness.is_settled) asked_ns = raw.stamp_ns;
    smooth_trajectory(samples, options, &restlessness);
    states.push_back(placed(raw, shape, samples[k - first]));
    if (lag_ns > 0 && frame.lagged_camera)
      carry(states.back().world_from_body, *frame.world_from_camera, *frame.lagged_camera);
  }
}

void finish_life(std::span<BodyState> states, const TrajectorySmootherOptions& options,
                 const LookAgain& look_again) {
  const Shape shape = states.back().shape;
  const auto smoothed = [&] {
    std::vector<PoseSample> samples;
    for (const BodyState& state : states) samples.push_back(sample_of(state, shape.body_from_object));
    smooth_trajectory(samples, options);
    return samples;
  };
  std::vector<PoseSample> samples = smoothed();
  const auto is_guess = [](const BodyState& state) { return state.evidence == PoseEvidence::guess; };
  if (std::ranges::any_of(states, is_guess)) {
    const Pose object_from_body = shape.body_from_object.inverse();
    for (std::size_t i = 0; i < states.size(); ++i)
      if (is_guess(states[i])) look_again(states[i], samples[i].world_from_object * object_from_body);
    samples = smoothed();
  }
  for (std::size_t i = 0; i < states.size(); ++i) states[i] = placed(states[i], shape, samples[i]);
}

}  // namespace

std::vector<BodyState> states_known_after(std::int64_t lag_ns, const std::vector<RawState>& raw,
                                          const TrajectorySmootherOptions& options) {
  std::vector<BodyState> states;
  for (auto begin = raw.begin(); begin != raw.end();) {
    const auto end = end_of_life(begin, raw.end(), [](const RawState& r) { return r.state.beginning; });
    const bool leads_nowhere = end != raw.end() && !was_ever_active({begin, end});
    const std::int64_t given_up_ns =
        leads_nowhere ? end->state.stamp_ns : std::numeric_limits<std::int64_t>::max();
    add_life({begin, end}, lag_ns, given_up_ns, options, states);
    begin = end;
  }
  return states;
}

std::vector<BodyState> final_states(const std::vector<RawState>& raw,
                                    const TrajectorySmootherOptions& options, const LookAgain& look_again) {
  if (raw.empty()) return {};
  std::set<int> lives = {raw.back().state.beginning};
  for (const auto& [state, frame] : raw)
    if (state.status == ObjectStatus::active) lives.insert(state.beginning);
  std::vector<BodyState> states;
  for (const auto& [state, frame] : raw) {
    if (!lives.contains(state.beginning)) continue;
    states.push_back(state);
    carry(states.back().world_from_body, *frame.world_from_camera, *frame.final_camera);
  }
  for (auto begin = states.begin(); begin != states.end();) {
    const auto end = end_of_life(begin, states.end(), [](const BodyState& state) { return state.beginning; });
    finish_life({begin, end}, options, look_again);
    begin = end;
  }
  return states;
}

}  // namespace uniquadric
