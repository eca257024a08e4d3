// Which of several poses of a body all that a frame shows speaks for.
#include <algorithm>
#include <vector>

#include "estimator/objects/body_estimator.h"

namespace uniquadric {
namespace {

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

// By the surface, from where it was expected since a time.
std::optional<CloudAlignment> BodyEstimator::aligned_from(const PerceivedFrame& frame,
                                                          const BodyObservation& body,
                                                          const SurfaceModel& surface,
                                                          const Pose& camera_from_body,
                                                          std::int64_t since_ns) const {
  return align_to_cloud(camera_, body, surface, camera_from_body, prediction_sigmas_at(frame, since_ns),
                        is_stale(frame), options_.alignment);
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
  for (const Pose& expected : expected_at(frame, body))
    if (const auto rival = aligned_from(frame, body, surface, expected, recent_.back().stamp_ns))
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

}  // namespace uniquadric
