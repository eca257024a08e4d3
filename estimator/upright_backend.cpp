#include "estimator/upright_backend.h"

#include <cmath>
#include <limits>
#include <map>

#include "core/base/seconds.h"
#include "estimator/upright/upright_filter.h"

namespace uniquadric {
namespace {

constexpr std::int64_t kAll = std::numeric_limits<std::int64_t>::max() / 2;  // the end, as a lag [ns]
constexpr double kUprightSigma = 0.02;  // [rad] of a street's slope and a body's sway
constexpr double kMovingSigmas = 3;     // of the speed, by which a body clearly moves

ObjectState object_state(const UprightState& state) {
  ObjectState object;
  object.frame = state.frame;
  object.stamp_ns = state.stamp_ns;
  object.ellipsoid.semi_axes_m = state.mean.tail<3>() / 2;
  const double yaw_rad = state.mean[kYaw];
  object.ellipsoid.world_from_object.rotation =
      Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()));
  object.ellipsoid.world_from_object.translation << state.mean.head<2>(),
      state.bottom_m + state.mean[kHeight] / 2;
  object.exponents = {1, 1, 1};
  const Eigen::Matrix2d to_object = Eigen::Rotation2Dd(-yaw_rad).toRotationMatrix();
  const auto variance = [&](int entry) { return std::max(0.0, state.covariance(entry, entry)); };
  const Eigen::Matrix2d place = to_object * state.covariance.topLeftCorner<2, 2>() * to_object.transpose();
  object.covariance_diagonal << variance(kLength) / 4, variance(kWidth) / 4, variance(kHeight) / 4,
      place.diagonal().cwiseMax(0), variance(kHeight) / 4, kUprightSigma * kUprightSigma,
      kUprightSigma * kUprightSigma, variance(kYaw);
  object.status = state.is_seen ? ObjectStatus::active : ObjectStatus::occluded;
  if (std::abs(state.mean[kSpeed]) > kMovingSigmas * std::sqrt(variance(kSpeed)))
    object.motion = ObjectMotion::moving;
  return object;
}

// By how perception moved the body on, which is along the ground.
Eigen::Vector2d velocity_of(const FrameInfo& before, const FrameInfo& frame, const BodyObservation& body) {
  if (!body.motion || !before.world_from_camera) return Eigen::Vector2d::Zero();
  const Pose moved = *frame.world_from_camera * *body.motion * before.world_from_camera->inverse();
  return moved.translation.head<2>() / seconds(before.stamp_ns, frame.stamp_ns);
}

// Without what was predicted after the last sight.
void add_track(int id, const std::vector<UprightState>& states, std::vector<ObjectTrack>& tracks) {
  ObjectTrack& track = tracks.emplace_back();
  track.id = id;
  std::size_t end = states.size();
  while (end > 0 && !states[end - 1].is_seen) --end;
  for (std::size_t i = 0; i < end; ++i) track.states.push_back(object_state(states[i]));
}

// One body through the frames.
struct BodyRun {
  explicit BodyRun(const UprightBoxOptions& options) : filter(options) {}

  UprightFilter filter;
  std::vector<UprightFrame> early;  // from its first sight until it was known to be a body
  std::int64_t known_ns = 0, seen_ns = 0;
  bool is_known = false;

  // As known a lag after each frame, or at the end.
  std::vector<UprightState> smoothed(std::int64_t lag_ns) {
    std::vector<UprightState> states = filter.smoothed(lag_ns);
    const auto from = std::partition_point(early.begin(), early.end(), [&](const UprightFrame& frame) {
      return known_ns - frame.stamp_ns > lag_ns;
    });
    const auto before = filter.before(states.front(), {from, early.end()});
    states.insert(states.begin(), before.begin(), before.end());
    return states;
  }
};

}  // namespace

BackendResult estimate_upright(const Perception& perception, const Variant& variant) {
  const UprightBoxOptions& options = variant.upright;
  BackendResult result;
  std::map<int, BodyRun> bodies;
  FrameInfo before;
  for (std::size_t i = 0; i < perception.frames().size(); ++i) {
    const PerceivedFrame frame = perception.read(i);
    if (!frame.world_from_camera) continue;
    Stopwatch watch(frame.frame, result.times);
    std::map<int, const BodyObservation*> seen;
    for (const BodyObservation& body : frame.bodies)
      if (body.points.cols() > 0) seen[body.id] = &body;
    for (auto& [id, body] : bodies) {
      if (seen.contains(id)) continue;
      if (!body.is_known)
        body.early.push_back({frame.frame, frame.stamp_ns, std::nullopt});
      else if (seconds(body.seen_ns, frame.stamp_ns) <= options.lost_after_s)
        body.filter.step(frame.frame, frame.stamp_ns, nullptr);
    }
    for (const auto& [id, observation] : seen) {
      BodyRun& body = bodies.try_emplace(id, options).first->second;
      const UprightSight seen_then = upright_sight(frame, *observation);
      const UprightSight sight = options.beam_gaps ? seen_then : without_gaps(seen_then);
      body.seen_ns = frame.stamp_ns;
      if (body.is_known) {
        body.filter.step(frame.frame, frame.stamp_ns, &sight);
      } else if (observation->known_at_frame > frame.frame) {
        body.early.push_back({frame.frame, frame.stamp_ns, sight});
      } else {
        body.is_known = true;
        body.known_ns = frame.stamp_ns;
        body.filter.start(sight, velocity_of(before, frame, *observation));
      }
    }
    before = frame;
    watch.stop("upright");
  }
  result.fixed_lag.emplace();
  result.final.emplace();
  for (auto& [id, body] : bodies) {
    if (!body.is_known) continue;
    add_track(id, body.filter.causal(), result.causal);
    add_track(id, body.smoothed(nanoseconds(variant.perception.fixed_lag_s)), *result.fixed_lag);
    add_track(id, body.smoothed(kAll), *result.final);
  }
  return result;
}

}  // namespace uniquadric
