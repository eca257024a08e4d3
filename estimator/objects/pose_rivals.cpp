// Where a body's surface places it, and which of several poses all that a frame shows speaks for.
#include <algorithm>
#include <numbers>
#include <vector>

#include "estimator/objects/assumed_surface.h"
#include "estimator/objects/body_estimator.h"

namespace uniquadric {
namespace {

constexpr double kHalfTurn = std::numbers::pi;  // any turn is as likely
constexpr double kClearly = 10;  // by which a pose must be likelier than another: as 20 of chi-square

}  // namespace

// camera_from_body of a body that goes on as before, comes to rest, or is where its points are.
std::vector<Pose> BodyEstimator::expected_at(const PerceivedFrame& frame, const BodyObservation& body) const {
  std::vector<Pose> expected = {predict(frame, nullptr), recent_.back().world_from_body};
  if (const auto center = center_by_points(frame, body))
    place_center(expected.emplace_back(expected.front()), *center);
  for (Pose& pose : expected) pose = frame.world_from_camera->inverse() * pose;
  return expected;
}

// By the surface, from where it was expected.
std::optional<CloudAlignment> BodyEstimator::aligned_from(const PerceivedFrame& frame,
                                                          const BodyObservation& body,
                                                          const SurfaceModel& surface,
                                                          const Pose& camera_from_body,
                                                          const PoseSigmas& sigmas) const {
  return align_to_cloud(camera_, body, surface, camera_from_body, sigmas, is_stale(frame),
                        options_.alignment);
}

std::vector<Disagreement> BodyEstimator::disagreements_of(const PerceivedFrame& frame,
                                                          const BodyObservation& body,
                                                          const SurfaceModel& surface,
                                                          const std::vector<Pose>& poses) const {
  return disagreements(camera_, body, surface, short_window_.sightings(body), options_.short_window.pose,
                       expected_at(frame, body), prediction_sigmas_at(frame, recent_.back().stamp_ns), poses,
                       options_.alignment);
}

// Whether all that is seen speaks for another pose than the features': few of them, as those of a highlight
// or a shadow, may agree on a motion that is not the body's.
bool BodyEstimator::gives_way(const PerceivedFrame& frame, const BodyObservation& body,
                              const Pose& camera_from_body) const {
  if (!options_.lifecycle.weighs_evidence || !body.silhouette || is_stale(frame)) return false;
  const SurfaceModel surface = shape_.surface();
  const Disagreement own = disagreements_of(frame, body, surface, {camera_from_body}).front();
  if (own.surface + own.way < kClearly) return false;  // of what features do not say; they are at their best
  std::vector<Pose> rivals;
  const PoseSigmas sigmas = prediction_sigmas_at(frame, recent_.back().stamp_ns);
  for (const Pose& expected : expected_at(frame, body))
    if (const auto rival = aligned_from(frame, body, surface, expected, sigmas))
      rivals.push_back(rival->camera_from_body);
  const auto theirs = disagreements_of(frame, body, surface, rivals);
  return std::ranges::any_of(theirs, [&](const Disagreement& d) { return d.all() + kClearly < own.all(); });
}

// Of where alignments from several starts ended. After a time out of sight no motion is expected any more.
std::optional<CloudAlignment> BodyEstimator::best_of(const PerceivedFrame& frame, const BodyObservation& body,
                                                     const SurfaceModel& surface,
                                                     const std::vector<CloudAlignment>& ends) const {
  if (ends.empty()) return std::nullopt;
  if (!options_.lifecycle.weighs_evidence || is_stale(frame))
    return *std::ranges::max_element(ends, {}, &CloudAlignment::matched);
  std::vector<Pose> poses;
  for (const CloudAlignment& end : ends) poses.push_back(end.camera_from_body);
  const auto against = disagreements_of(frame, body, surface, poses);
  return ends[std::ranges::min_element(against, {}, &Disagreement::all) - against.begin()];
}

// By what was seen of its surface; where a part of what is seen now is not on that, by the sides of its shape
// too: else a body slides along the one side that is known as others come into view.
std::optional<CloudAlignment> BodyEstimator::aligned(const PerceivedFrame& frame,
                                                     const BodyObservation& body) const {
  SurfaceModel surface = shape_.surface();
  const auto by_seen = aligned_to(frame, body, surface);
  const bool is_all_seen = by_seen && by_seen->matched > LifecycleOptions::sure_share;
  if (is_all_seen || is_stale(frame) || !options_.alignment.impacts || !surface.shape ||
      !is_known_all_around(shape_.shape()))
    return by_seen;
  assume_unseen(surface);
  const auto by_all = aligned_to(frame, body, surface);
  return by_all ? by_all : by_seen;
}

// By a surface alone: on from the last pose, at rest, where its points are, or after an impact.
std::optional<CloudAlignment> BodyEstimator::aligned_to(const PerceivedFrame& frame,
                                                        const BodyObservation& body,
                                                        const SurfaceModel& surface) const {
  const bool stale = is_stale(frame);
  std::vector<CloudAlignment> ends;
  const auto try_from = [&](const Pose& world_from_body, const PoseSigmas& sigmas) {
    const Pose start = frame.world_from_camera->inverse() * world_from_body;
    if (const auto end = aligned_from(frame, body, surface, start, sigmas)) ends.push_back(*end);
  };
  const PoseSigmas since_last = prediction_sigmas_at(frame, recent_.back().stamp_ns);
  Pose predicted = predict(frame, &body);
  try_from(predicted, since_last);
  if (!stale && options_.lifecycle.weighs_evidence) try_from(recent_.back().world_from_body, since_last);
  const auto center = stale ? shape_.center_of(frame, body) : center_by_points(frame, body);
  if (center) {
    place_center(predicted, *center);
    try_from(predicted, stale ? prediction_sigmas_at(frame, sure_ns_) : since_last);
  }
  if (!stale && options_.alignment.impacts) try_from(predicted, after_impact(since_last));
  const auto found = best_of(frame, body, surface, ends);
  if (stale || (found && !found->new_face)) return found;
  const auto by_shape = found_by_shape(frame, body, surface, predicted);
  return by_shape ? by_shape : found;
}

// A face that was not seen yet, as an impact turns up: where the shape says that there is one, or else, of a
// body of which nothing is hidden, about the middle of its outline, turned in any way. `predicted`:
// world_from_body.
std::optional<CloudAlignment> BodyEstimator::found_by_shape(const PerceivedFrame& frame,
                                                            const BodyObservation& body, SurfaceModel surface,
                                                            Pose predicted) const {
  if (!options_.alignment.impacts || keyframes_ < options_.lifecycle.confirm_keyframes) return std::nullopt;
  const Pose camera_from_world = frame.world_from_camera->inverse();
  if (surface.shape) {
    assume_unseen(surface);
    const auto found = aligned_from(frame, body, surface, camera_from_world * predicted,
                                    prediction_sigmas_at(frame, recent_.back().stamp_ns));
    if (found && !found->new_face) return found;
  }
  const auto center = is_whole(*body.silhouette) ? shape_.center_of(frame, body) : std::nullopt;
  if (!center) return std::nullopt;
  place_center(predicted, *center);
  const PoseSigmas anywhere{shape_.shape().semi_axes_m.maxCoeff(), kHalfTurn};
  const auto found = align_to_cloud(camera_, body, surface, camera_from_world * predicted, anywhere, true,
                                    options_.alignment);
  return found && found->matched > LifecycleOptions::sure_share ? found : std::nullopt;
}

}  // namespace uniquadric
