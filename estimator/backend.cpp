#include "estimator/backend.h"

#include <tbb/parallel_for.h>

#include <set>

namespace uniquadric {
namespace {

const BodyObservation* find_body(const PerceivedFrame& frame, int id) {
  for (const BodyObservation& body : frame.bodies)
    if (body.id == id) return &body;
  return nullptr;
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
  return state;
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
    Stopwatch watch(frame.frame, result.times);
    const BodyObservation* body = find_body(frame, id);
    if (auto state = estimator.step(frame, body))
      states.push_back(std::move(*state));
    else
      result.without_state += body != nullptr;
    watch.stop("windows");
  }
  if (variant.output == Output::final)
    for (BodyState& state : states) state.shape = states.back().shape;
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
