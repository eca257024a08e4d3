#include "estimator/objects/joined_backend.h"

#include "core/geometry/superquadric.h"

namespace uniquadric {
namespace {

// The camera at constant velocity.
std::optional<Pose> next_camera(const Trajectory& recent, std::int64_t stamp_ns) {
  if (recent.size() < 2) return std::nullopt;
  const auto& [before_ns, before] = recent.front();
  const auto& [last_ns, last] = recent.back();
  const double ratio = static_cast<double>(stamp_ns - last_ns) / static_cast<double>(last_ns - before_ns);
  return predict_pose(before, last, ratio, MotionModel::screw);
}

BodyEnvelope envelope_of(const Shape& shape, const Pose& camera_from_object, const JoinedOptions& options) {
  Superellipsoid body = shape.superellipsoid();
  body.semi_axes_m = ((1 + options.envelope_margin) * shape.semi_axes_m).array() + options.envelope_slack_m;
  return [body, object_from_camera = camera_from_object.inverse()](const Eigen::Vector3d& p) {
    return gauge(body, object_from_camera * p) <= 1;
  };
}

}  // namespace

BodyHints JoinedBackend::hints(std::int64_t frame, std::int64_t stamp_ns) {
  BodyHints hints;
  const auto world_from_camera = next_camera(recent_, stamp_ns);
  if (!world_from_camera) return hints;
  PerceivedFrame next;
  next.frame = frame;
  next.stamp_ns = stamp_ns;
  next.world_from_camera = world_from_camera;
  for (const auto& [id, body] : by_id_) {
    if (!body.state || body.state->status != ObjectStatus::active) continue;
    const Pose camera_from_body = world_from_camera->inverse() * body.estimator.predict(next, nullptr);
    BodyHint& hint = hints[id];
    hint.motion = camera_from_body * body.state->world_from_body.inverse() * recent_.back().pose;
    hint.envelope =
        envelope_of(body.state->shape, camera_from_body * body.state->shape.body_from_object, options_);
  }
  return hints;
}

void JoinedBackend::take(const PerceivedFrame& frame) {
  if (!frame.world_from_camera) {  // nothing is known of where anything is
    recent_.clear();
    for (auto& [id, body] : by_id_) body.state.reset();
    return;
  }
  recent_.push_back({frame.stamp_ns, *frame.world_from_camera});
  if (recent_.size() > 2) recent_.erase(recent_.begin());
  std::map<int, const BodyObservation*> seen;
  for (const BodyObservation& body : frame.bodies) {
    seen[body.id] = &body;
    if (!by_id_.contains(body.id))
      by_id_.emplace(body.id, Body{BodyEstimator(body.id, camera_, bodies_, seed_), std::nullopt});
  }
  for (auto& [id, body] : by_id_) {
    const auto found = seen.find(id);
    body.state = body.estimator.step(frame, found == seen.end() ? nullptr : found->second);
  }
}

}  // namespace uniquadric
