#include "estimator/backend.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <set>
#include <span>

namespace uniquadric {
namespace {

const BodyObservation* find_body(const PerceivedFrame& frame, int id) {
  for (const BodyObservation& body : frame.bodies)
    if (body.id == id) return &body;
  return nullptr;
}

Matrix6d turned(const Eigen::Quaterniond& rotation) {
  Matrix6d result = Matrix6d::Zero();
  result.topLeftCorner<3, 3>() = result.bottomRightCorner<3, 3>() = rotation.toRotationMatrix();
  return result;
}

// Variances of the body's own frame and of the shape's place in it add up: first order, turned into the
// object's axes.
Vector9d variances_of(const BodyState& body) {
  const Eigen::Matrix3d R = body.shape.body_from_object.rotation.toRotationMatrix();
  const Matrix6d& covariance = body.covariance;
  Vector9d variances = body.shape.variances;
  variances.segment<3>(3) += (R.transpose() * covariance.topLeftCorner<3, 3>() * R).diagonal();
  variances.segment<3>(6) += (R.transpose() * covariance.bottomRightCorner<3, 3>() * R).diagonal();
  return variances;
}

ObjectState object_state(const BodyState& body) {
  ObjectState state;
  state.frame = body.frame;
  state.stamp_ns = body.stamp_ns;
  state.ellipsoid = {body.world_from_body * body.shape.body_from_object, body.shape.semi_axes_m};
  state.ellipsoid.world_from_object.rotation.normalize();
  state.exponent = body.shape.exponents.outline;
  state.covariance_diagonal = variances_of(body);
  state.status = body.status;
  state.motion = body.motion;
  return state;
}

// The states of one frame's life as they are known at its end: the last shape, the whole trajectory smoothed.
// From here on the body's frame is the object's.
void finish_life(std::span<BodyState> states, const TrajectorySmootherOptions& options) {
  const Shape shape = states.back().shape;
  const Matrix6d turn = turned(shape.body_from_object.rotation.inverse());
  std::vector<PoseSample> samples;
  for (BodyState& state : states)
    samples.push_back({state.stamp_ns, state.world_from_body * shape.body_from_object,
                       turn * state.covariance * turn.transpose(), state.evidence});
  smooth_trajectory(samples, options);
  for (std::size_t i = 0; i < states.size(); ++i) {
    states[i].shape = shape;
    states[i].shape.body_from_object = Pose();
    states[i].world_from_body = samples[i].world_from_object;
    states[i].covariance = samples[i].covariance;
  }
}

void finish(std::vector<BodyState>& states, const TrajectorySmootherOptions& options) {
  for (auto begin = states.begin(); begin != states.end();) {
    const auto end = std::find_if(
        begin, states.end(), [&](const BodyState& state) { return state.beginning != begin->beginning; });
    finish_life({begin, end}, options);
    begin = end;
  }
}

struct BodyTrack {
  ObjectTrack track;
  int without_state = 0;
  std::vector<StageTime> times;
};

BodyTrack estimate_body(const Perception& perception, int id, const Variant& variant, std::uint64_t seed) {
  BodyTrack result;
  result.track.id = id;
  BodyEstimator estimator(id, perception.camera, variant.body, seed);
  std::vector<BodyState> states;
  for (const PerceivedFrame& frame : perception.frames) {
    std::vector<StageTime> windows, solutions;
    Stopwatch watch(frame.frame, windows);
    const BodyObservation* body = find_body(frame, id);
    if (auto state = estimator.step(frame, body, &solutions))
      states.push_back(std::move(*state));
    else
      result.without_state += body != nullptr;
    watch.stop("windows");
    for (StageTime& solution : solutions) {
      solution.frame = frame.frame;
      windows.back().ms -= solution.ms;  // stages do not overlap
    }
    result.times.insert(result.times.end(), solutions.begin(), solutions.end());
    result.times.push_back(windows.back());
  }
  if (variant.output == Output::final) finish(states, variant.body.trajectory);
  for (const BodyState& state : states) result.track.states.push_back(object_state(state));
  return result;
}

}  // namespace

BackendResult estimate_windows(const Perception& perception, const Variant& variant, std::uint64_t seed) {
  std::set<int> ids;
  for (const PerceivedFrame& frame : perception.frames)
    for (const BodyObservation& body : frame.bodies) ids.insert(body.id);
  const std::vector<int> order(ids.begin(), ids.end());
  std::vector<BodyTrack> tracks(order.size());
  tbb::parallel_for(std::size_t{0}, order.size(),
                    [&](std::size_t i) { tracks[i] = estimate_body(perception, order[i], variant, seed); });
  BackendResult result;
  for (BodyTrack& body : tracks) {
    result.observations_without_state += body.without_state;
    result.times.insert(result.times.end(), body.times.begin(), body.times.end());
    if (!body.track.states.empty()) result.objects.push_back(std::move(body.track));
  }
  return result;
}

}  // namespace uniquadric
