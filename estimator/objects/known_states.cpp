#include "estimator/objects/known_states.h"

#include <algorithm>
#include <limits>
#include <set>
#include <span>

#include "estimator/factors/pose_jacobian.h"

namespace uniquadric {
namespace {

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

// Adds the states of a life that was given up at a time.
void add_life(std::span<const RawState> life, std::int64_t lag_ns, std::int64_t given_up_ns,
              const TrajectorySmootherOptions& options, std::vector<BodyState>& states) {
  const auto history_ns = static_cast<std::int64_t>(1e9 * options.history_s);
  Restlessness restlessness;
  std::size_t first = 0, known = 0;
  for (std::size_t k = 0; k < life.size(); ++k) {
    const auto& [raw, frame] = life[k];
    const std::int64_t now_ns = raw.stamp_ns + lag_ns;
    if (given_up_ns <= now_ns) return;
    while (life[first].state.stamp_ns < raw.stamp_ns - history_ns) ++first;
    while (known < life.size() && life[known].state.stamp_ns <= now_ns) ++known;
    const Shape& shape = life[known - 1].state.shape;
    std::vector<PoseSample> samples;
    for (std::size_t i = first; i < known; ++i)
      samples.push_back(sample_of(life[i].state, shape.body_from_object));
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
