// Where a body is expected, and where it is while nobody finds it.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "core/base/seconds.h"
#include "estimator/objects/body_estimator.h"

namespace uniquadric {
namespace {

constexpr double kPredictionSigma = 0.02;            // [m], [rad] of a prediction over one frame
constexpr double kLeastBase = 0.2, kMostBase = 0.6;  // [s] of the time that the velocity is taken from
constexpr double kReachSigmas = 3;                   // of the prediction, within which the body is
constexpr double kRest =
    0.7;  // [s]: the turn of a body that is not seen fades, which a wrong velocity would carry furthest

// Of its centre from where that is expected, with its parts [m].
double reach_of(const Shape& shape, const PoseSigmas& sigmas) {
  return kReachSigmas * sigmas.translation_m + shape.semi_axes_m.maxCoeff();
}

}  // namespace

void BodyEstimator::remember(const PerceivedFrame& frame, const Pose& world_from_body,
                             const Matrix6d& covariance) {
  said_lost_ = false;
  recent_.push_back({frame.frame, frame.stamp_ns, *frame.world_from_camera, world_from_body, covariance});
  while (seconds(recent_.front().stamp_ns, frame.stamp_ns) > kMostBase) recent_.pop_front();
}

// From perception's own frame-to-frame motion where the last frame was tracked, else at constant velocity.
Pose BodyEstimator::predict(const PerceivedFrame& frame, const BodyObservation* body) const {
  const Tracked& last = recent_.back();
  if (body && body->motion && last.frame == frame.frame - 1)
    return *frame.world_from_camera * *body->motion * last.world_from_camera.inverse() * last.world_from_body;
  if (motion_.now() == ObjectMotion::at_rest) return last.world_from_body;
  const double ahead_s = seconds(last.stamp_ns, frame.stamp_ns);
  const Tracked& first = *std::find_if(recent_.begin(), std::prev(recent_.end()), [&](const Tracked& t) {
    return seconds(t.stamp_ns, last.stamp_ns) <= std::clamp(ahead_s, kLeastBase, kMostBase);
  });
  const double base_s = seconds(first.stamp_ns, last.stamp_ns);
  if (base_s <= 0) return last.world_from_body;
  const double share = ahead_s / base_s;
  Pose pose;
  const Eigen::Vector3d turn =
      log_so3(last.world_from_body.rotation * first.world_from_body.rotation.inverse());
  const double faded = kRest * -std::expm1(-ahead_s / kRest) / base_s;
  pose.rotation = (exp_so3(faded * turn) * last.world_from_body.rotation).normalized();
  // what moves steadily is the centre, not the origin of the window's frame
  const Eigen::Vector3d c = body_center();
  const Eigen::Vector3d center =
      (1 + share) * (last.world_from_body * c) - share * (first.world_from_body * c);
  pose.translation = center - pose.rotation * c;
  return pose;
}

PoseSigmas BodyEstimator::prediction_sigmas_at(const PerceivedFrame& frame, std::int64_t since_ns) const {
  const double t = seconds(since_ns, frame.stamp_ns);
  const LifecycleOptions& o = options_.lifecycle;
  return {kPredictionSigma + o.acceleration_mps2 * t * t / 2,
          kPredictionSigma + o.angular_acceleration_radps2 * t * t / 2};
}

// Whether all of it is beyond the image's border, or behind the camera, by more than its place is uncertain.
bool BodyEstimator::has_left(const PerceivedFrame& frame, const Pose& world_from_body, double sigma_m) const {
  if (!options_.lifecycle.ends_outside) return false;
  const Eigen::Vector3d middle_m = frame.world_from_camera->inverse() * (world_from_body * body_center());
  const double reach_m = shape_.shape().semi_axes_m.maxCoeff() + sigma_m;
  if (middle_m.z() < reach_m) return middle_m.z() < -reach_m;
  const Eigen::Vector2d pixel = (camera_.matrix() * middle_m).hnormalized();
  const Eigen::Vector2d reach_px = reach_m / middle_m.z() * Eigen::Vector2d(camera_.fx, camera_.fy);
  return (pixel + reach_px).minCoeff() < 0 || pixel.x() - reach_px.x() > camera_.width ||
         pixel.y() - reach_px.y() > camera_.height;
}

// Whether it is further from where it was expected than an impact explains.
bool BodyEstimator::is_out_of_reach(const PerceivedFrame& frame, const Pose& world_from_body) const {
  const Eigen::Vector3d expected = predict(frame, nullptr) * body_center();
  const PoseSigmas sigmas = after_impact(prediction_sigmas_at(frame, recent_.back().stamp_ns));
  const double reach_m = reach_of(shape_.shape(), sigmas);
  return (world_from_body * body_center() - expected).norm() > reach_m;
}

// Where its motion leads it, or where its mask is after a time; nothing once it was said to be lost.
std::optional<BodyState> BodyEstimator::unseen(const PerceivedFrame& frame, const BodyObservation* body) {
  const PoseSigmas sigmas = prediction_sigmas_at(frame, sure_ns_);
  Pose world_from_body = predict(frame, body);
  const bool is_lost = seconds(recent_.back().stamp_ns, frame.stamp_ns) > options_.lifecycle.lost_after_s ||
                       (!body && has_left(frame, world_from_body, sigmas.translation_m)) ||
                       (!body && options_.lifecycle.ends_unplaced && motion_.now() != ObjectMotion::at_rest &&
                        sigmas.translation_m > shape_.shape().semi_axes_m.maxCoeff());
  if (is_lost && std::exchange(said_lost_, true)) return std::nullopt;
  Matrix6d predicted = recent_.back().covariance;
  predicted.diagonal().head<3>().array() += sigmas.translation_m * sigmas.translation_m;
  predicted.diagonal().tail<3>().array() += sigmas.rotation_rad * sigmas.rotation_rad;
  auto center = body && is_stale(frame) ? shape_.center_of(frame, *body) : std::nullopt;
  const double reach_m = reach_of(shape_.shape(), sigmas);
  if (center && !is_whole(*body->silhouette) && (*center - world_from_body * body_center()).norm() > reach_m)
    center.reset();  // what lies about that part may be its occluder
  if (center) place_center(world_from_body, *center);
  BodyState state = state_at(frame, world_from_body, predicted);
  state.status = is_lost ? ObjectStatus::lost : ObjectStatus::occluded;
  // of a part alone the centre is not known well enough to count
  state.evidence = center && is_whole(*body->silhouette) ? PoseEvidence::guess : PoseEvidence::none;
  return state;
}

}  // namespace uniquadric
