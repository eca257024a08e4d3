#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "estimator/features/frame_view.h"
#include "estimator/features/track_gallery.h"

namespace uniquadric {
namespace {

constexpr double kMinFacing = 0.25;        // cosine between the surface's normal and the line of sight
constexpr double kMostTriesPerWanted = 3;  // lost tracks looked at, per track wanted
constexpr int kLooksWhereLeft = 2;         // the second from the pose that the first one told

// A track whose place in the image is known approximately, put where its anchor fits; nothing when it does
// not fit or the surface there is another.
std::optional<PointTrack> found_again(const FrameView& view, const TrackedBody& body, const PointTrack& lost,
                                      const Pose& pose, const Eigen::Vector2d& pixel) {
  const auto warp = anchor_warp(*lost.anchor, lost.landmark->surface(), view.lens, pose);
  if (!warp) return std::nullopt;
  const Eigen::Vector2d stretch = Eigen::JacobiSVD<Eigen::Matrix2d>(*warp).singularValues();
  if (stretch[0] > 2 || stretch[1] < 0.5) return std::nullopt;
  const auto aligned = align_patch(*lost.anchor, *warp, view.gray, pixel, view.options.alignment);
  if (!aligned || aligned->correlation < view.options.min_anchor_correlation ||
      aligned->sigma_px > view.options.max_pixel_sigma)
    return std::nullopt;
  PointTrack track = lost;
  if (!view.place(track, aligned->pixel, body) || view.regions.label(track.at_stamp) != body.label ||
      !view.belongs(body.label, track))
    return std::nullopt;
  if (view.depth.empty()) return track;
  const double expected = (pose * lost.landmark->point).z();
  const auto& motion = view.options.motion;
  if (!track.depth || std::abs(track.depth->depth_m - expected) >
                          motion.depth_gate * track.depth->sigma_m + motion.depth_slack_m)
    return std::nullopt;
  return track;
}

std::optional<Eigen::Vector2d> expected_pixel(const FrameView& view, const TrackedBody& body,
                                              const PointTrack& lost, const Spacing& spacing) {
  const Eigen::Vector3d p = *body.camera_from_map * lost.landmark->point;
  const Eigen::Vector3d normal = body.camera_from_map->rotation * lost.landmark->surface().normal;
  if (-normal.dot(p.normalized()) < kMinFacing) return std::nullopt;
  const auto at_stamp = view.lens.project(p);
  if (!at_stamp || view.regions.label(*at_stamp) != body.label || !view.regions.is_well_inside(*at_stamp))
    return std::nullopt;
  const auto pixel = view.shutter.seen_at(p, body.twist);
  return pixel && spacing.is_free(*pixel) ? pixel : std::nullopt;
}

std::vector<GalleryQuery> queries_of(const std::vector<PointTrack>& corners, int label,
                                     const FrameView& view) {
  std::vector<GalleryQuery> queries;
  for (const auto& corner : corners) {
    GalleryQuery query{{Eigen::Vector3d::Zero(), corner.undistorted}, {}};
    if (corner.depth && view.regions.label(corner.pixel) == label) {
      query.sighting.depth_m = corner.depth->depth_m;
      query.sighting.depth_sigma_m = corner.depth->sigma_m;
      query.descriptors = corner.descriptors;
    }
    queries.push_back(std::move(query));
  }
  return queries;
}

std::int64_t count_landmarks(const TrackedBody& body) {
  return std::count_if(body.tracks.begin(), body.tracks.end(),
                       [](const auto& t) { return t.landmark.has_value(); });
}

// The recognised corners and tracks become the tracks that they are.
void take_back(const FrameView& view, TrackedBody& body, const Recognition& seen,
               std::vector<PointTrack>& corners, std::size_t first_corner) {
  std::vector<bool> corner_used(corners.size(), false), track_used(body.tracks.size(), false);
  std::vector<bool> entry_used(body.gallery.size(), false);
  std::vector<PointTrack> back;
  for (const auto& [query, entry] : seen.matches) {
    const bool is_corner = query >= first_corner;
    const Eigen::Vector2d at = is_corner ? corners[query - first_corner].pixel : body.tracks[query].pixel;
    auto track = found_again(view, body, body.gallery[entry], *body.camera_from_map, at);
    if (!track) continue;
    if (is_corner)
      corner_used[query - first_corner] = true;
    else
      track_used[query] = true;
    entry_used[entry] = true;
    back.push_back(std::move(*track));
  }
  const auto erase_used = [](std::vector<PointTrack>& tracks, const std::vector<bool>& used) {
    std::size_t i = 0;
    std::erase_if(tracks, [&](const PointTrack&) { return used[i++]; });
  };
  erase_used(corners, corner_used);
  erase_used(body.tracks, track_used);
  erase_used(body.gallery, entry_used);
  std::move(back.begin(), back.end(), std::back_inserter(body.tracks));
}

}  // namespace

void return_expected_tracks(const FrameView& view, TrackedBody& body, Spacing& spacing, double distance_px,
                            int wanted) {
  if (!body.camera_from_map) return;
  std::vector<bool> returned(body.gallery.size(), false);
  int tries = static_cast<int>(kMostTriesPerWanted * wanted);
  for (std::size_t i = body.gallery.size(); i-- > 0 && wanted > 0 && tries > 0;) {
    PointTrack& lost = body.gallery[i];
    // One that has not been found often is looked for seldom.
    if (lost.map != body.map || (view.frame + lost.id) % (1 + lost.tries) != 0) continue;
    const auto pixel = expected_pixel(view, body, lost, spacing);
    if (!pixel) continue;
    --tries;
    auto track = found_again(view, body, lost, *body.camera_from_map, *pixel);
    if (!track) {
      ++lost.tries;
      continue;
    }
    spacing.take(track->pixel, distance_px);
    body.tracks.push_back(std::move(*track));
    returned[i] = true;
    --wanted;
  }
  std::size_t i = 0;
  std::erase_if(body.gallery, [&](const PointTrack&) { return returned[i++]; });
}

void return_where_left(const FrameView& view, TrackedBody& body, double distance_px, int wanted) {
  const GalleryOptions& options = view.options.gallery;
  if (body.camera_from_map || !options.look_where_left) return;
  std::erase_if(body.left, [&](const auto& left) {
    return std::none_of(body.gallery.begin(), body.gallery.end(),
                        [&](const auto& t) { return t.map == left.first; });
  });
  for (const auto& [map, camera_from_map] : body.left) {
    TrackedBody trial = body;
    trial.map = map;
    trial.camera_from_map = camera_from_map;
    for (auto& lost : trial.gallery) lost.tries = 0;  // in vain: the camera saw nothing
    Spacing spacing(view.gray.size());
    for (const auto& track : body.tracks) spacing.take(track.pixel, distance_px);
    bool fits = true;
    for (int look = 0; look < kLooksWhereLeft && fits; ++look) {
      return_expected_tracks(view, trial, spacing, distance_px, wanted);
      fits = fit_pose(view, trial, *trial.camera_from_map, 1);
    }
    if (!fits || count_landmarks(trial) < options.min_matches) continue;
    trial.left.clear();
    body = std::move(trial);
    return;
  }
}

void recognise_body(const FrameView& view, TrackedBody& body, std::vector<PointTrack>& corners) {
  std::vector<int> maps;  // that the camera could be in, the last one first
  for (int map = body.maps - 1; map >= 0; --map)
    if (!(body.camera_from_map && map == body.map) &&
        std::any_of(body.gallery.begin(), body.gallery.end(), [&](const auto& t) { return t.map == map; }))
      maps.push_back(map);
  if (maps.empty()) return;
  std::vector<PointTrack> candidates = body.tracks;
  std::copy(corners.begin(), corners.end(), std::back_inserter(candidates));
  const auto queries = queries_of(candidates, body.label, view);
  RandomStream random(view.seed, "recognition", view.frame, body.label);
  for (const int map : maps) {
    const auto seen = recognise(queries, body.gallery, map, view.camera, view.options.gallery, random);
    if (!seen) continue;
    const std::size_t first_corner = body.tracks.size();
    if (body.camera_from_map) join_map(body, map, seen->camera_from_map.inverse() * *body.camera_from_map);
    body.camera_from_map = seen->camera_from_map;
    body.map = map;
    body.left.clear();
    take_back(view, body, *seen, corners, first_corner);
    fit_pose(view, body, seen->camera_from_map, 1);
    return;
  }
}

}  // namespace uniquadric
