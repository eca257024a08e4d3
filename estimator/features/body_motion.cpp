#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "estimator/features/frame_view.h"
#include "estimator/observation/ideal_ray.h"

namespace uniquadric {
namespace {

constexpr int kMostFailures = 3;             // of a track before it is forgotten for good
constexpr int kMostRounds = 4;               // of pose and twist in turn
constexpr double kShareOfMiddleRows = 0.15;  // of the sightings that must agree at first

struct Sightings {
  std::vector<PointSighting> of;
  std::vector<std::size_t> places;  // of their tracks
};

Sightings sightings_of(const TrackedBody& body, const Pose& about) {
  Sightings sightings;
  const Eigen::Vector3d ray = about.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  for (std::size_t i = 0; i < body.tracks.size(); ++i) {
    const PointTrack& track = body.tracks[i];
    if (!track.landmark) continue;
    PointSighting s{track.landmark->point, track.undistorted};
    if (track.depth) {
      const double own = ray.dot(track.landmark->information.inverse() * ray);
      s.depth_m = track.depth->depth_m;
      s.depth_sigma_m = std::sqrt(track.depth->sigma_m * track.depth->sigma_m + own);
    }
    sightings.of.push_back(s);
    sightings.places.push_back(i);
  }
  return sightings;
}

void drop_outliers(const FrameView& view, TrackedBody& body, const std::vector<std::size_t>& places,
                   const std::vector<bool>& inlier) {
  std::vector<bool> outlier(body.tracks.size(), false);
  for (std::size_t i = 0; i < places.size(); ++i) outlier[places[i]] = !inlier[i];
  std::vector<PointTrack> kept;
  for (std::size_t i = 0; i < body.tracks.size(); ++i) {
    PointTrack& track = body.tracks[i];
    if (!outlier[i])
      kept.push_back(std::move(track));
    else if (++track.failures < kMostFailures)
      retire(body, std::move(track), view.options.gallery.min_sightings, view.most_tracks(body.label));
  }
  body.tracks = std::move(kept);
}

enum class Fit { good, poor, none };

// Puts a track where its anchor's patch fits best.
Fit align_track(const FrameView& view, const TrackedBody& body, const Pose& pose, PointTrack& track) {
  const FeatureOptions& options = view.options;
  const auto warp = anchor_warp(*track.anchor, track.landmark->surface(), view.lens, pose);
  if (!warp) return Fit::none;
  const auto found = align_patch(*track.anchor, *warp, view.gray, track.pixel, options.alignment);
  if (!found || found->sigma_px > options.max_pixel_sigma || !view.place(track, found->pixel, body))
    return Fit::none;
  const Eigen::Vector2d stretch = Eigen::JacobiSVD<Eigen::Matrix2d>(*warp).singularValues();
  const bool is_near = stretch[0] <= options.max_anchor_warp && stretch[1] >= 1 / options.max_anchor_warp;
  return is_near && found->correlation >= options.min_anchor_correlation ? Fit::good : Fit::poor;
}

// Aligns all tracks. Takes new anchors where the old ones have become too different, and drops tracks that
// fit neither their anchors nor their landmarks.
void align(const FrameView& view, TrackedBody& body, const Pose& pose) {
  std::vector<PointTrack> kept;
  for (auto& track : body.tracks) {
    const bool is_known = track.landmark && track.depth;
    const Fit fit = is_known && track.anchor ? align_track(view, body, pose, track) : Fit::none;
    if (fit == Fit::none) view.place(track, track.pixel, body);
    if (is_known && fit != Fit::good) {
      const auto expected = view.camera.project(pose * track.landmark->point);
      if (fit == Fit::none && track.anchor &&
          !(expected && (*expected - track.undistorted).norm() < view.options.max_slip_px)) {
        retire(body, std::move(track), view.options.gallery.min_sightings, view.most_tracks(body.label));
        continue;
      }
      track.anchor = make_anchor(view.gray, track.pixel, pose);
    }
    kept.push_back(std::move(track));
  }
  body.tracks = std::move(kept);
}

// A map's frame is that of the camera when it was begun: this one's pose is the motion since the others were
// lost.
void leave_map(TrackedBody& body, const Pose& camera_from_map) {
  for (auto& [map, left] : body.left) left = camera_from_map * left;
  body.left[body.map] = camera_from_map;
}

void give_up(const FrameView& view, TrackedBody& body, bool tracks_too) {
  body.camera_from_map.reset();
  body.twist_known = false;
  for (auto& track : body.tracks) view.place(track, track.pixel, body);
  if (tracks_too) {
    for (auto& track : body.tracks)
      retire(body, std::move(track), view.options.gallery.min_sightings, view.most_tracks(body.label));
    body.tracks.clear();
  }
  for (auto& track : body.tracks) {
    track.landmark.reset();
    track.anchor.reset();
  }
}

// A track's depth is of the plane that was fitted where it was before.
void move_to_stamp(const FrameView& view, const TrackedBody& body, PointTrack& track) {
  const auto plane = track.depth;
  const Eigen::Vector2d place = track.at_stamp;
  if (!plane) return void(view.place(track, track.pixel, body));
  const auto moved = view.shutter.at_stamp(track.pixel, plane->depth_m, body.twist);
  const auto ray = moved ? view.lens.unproject(*moved) : std::nullopt;
  const double inverse_depth = 1 / plane->depth_m + (moved ? plane->slope_per_px.dot(*moved - place) : 0);
  if (!ray || !(inverse_depth > 0)) return;
  track.at_stamp = *moved;
  track.undistorted = ideal_pixel(view.camera, *ray);
  track.depth->depth_m = 1 / inverse_depth;
}

// Of the body, since its pose in the frame before.
Vector6d mean_twist(const FrameView& view, const Pose& pose, const Pose& before) {
  return log_se3(pose * before.inverse()) / (1e-9 * static_cast<double>(view.step_ns));
}

// Twist and pose by those sightings that count, of tracks as they lie; moves all tracks by it.
bool fit_twist(const FrameView& view, TrackedBody& body, const Pose& pose, const Pose& before,
               const Sightings& sightings, const std::vector<bool>& counts) {
  const Vector6d mean = mean_twist(view, pose, before);
  std::vector<PointSighting> agreed;
  std::vector<double> delays_s;
  for (std::size_t i = 0; i < sightings.of.size(); ++i) {
    if (!counts[i]) continue;
    agreed.push_back(sightings.of[i]);
    delays_s.push_back(view.shutter.delay_s(body.tracks[sightings.places[i]].pixel.y()));
  }
  const auto fit = fit_moving_pose(agreed, delays_s, view.camera, {pose, body.twist}, mean,
                                   view.options.motion.pixel_sigma, view.options.rolling_shutter);
  if (!fit) return false;
  body.camera_from_map = fit->camera_from_body;
  body.twist = fit->twist;
  for (auto& track : body.tracks) move_to_stamp(view, body, track);
  return true;
}

// The first motion tells where the rows saw what was taken for seen at the stamp: that is measured anew.
void begin_landmarks_anew(const FrameView& view, TrackedBody& body) {
  for (auto& track : body.tracks) {
    view.place(track, track.pixel, body);
    track.landmark.reset();
    track.anchor.reset();
  }
}

}  // namespace

std::optional<Pose> expected_pose(const FrameView& view, const TrackedBody& body) {
  const auto hint = view.hints.find(body.label);
  if (hint != view.hints.end() && hint->second.motion && body.camera_from_map) {
    Pose pose = *hint->second.motion * *body.camera_from_map;
    pose.rotation.normalize();
    return pose;
  }
  if (view.step_ns > std::int64_t(view.options.max_prediction_gap_s * 1e9)) return body.camera_from_map;
  return predicted_pose(body, view.step_ns);
}

bool fit_pose(const FrameView& view, TrackedBody& body, const Pose& prior, int pass) {
  const Sightings sightings = sightings_of(body, prior);
  RandomStream random(view.seed, pass == 0 ? "rigid_motion" : "rigid_motion_again", view.frame, body.label);
  RigidMotionOptions options = view.options.motion;
  if (pass > 0) options.pixel_gate = view.options.aligned_pixel_gate;
  const auto fit = fit_rigid_motion(sightings.of, view.camera, prior, options, random);
  if (!fit) return false;
  body.camera_from_map = fit->camera_from_body;
  drop_outliers(view, body, sightings.places, fit->inlier);
  return true;
}

void move_body(const FrameView& view, TrackedBody& body) {
  const auto before = body.camera_from_map;
  auto prior = expected_pose(view, body);
  body.motion.reset();
  if (!before) return;
  const auto with_landmark = std::count_if(body.tracks.begin(), body.tracks.end(),
                                           [](const auto& t) { return t.landmark.has_value(); });
  prior = follow_twist(view, body, *prior);
  bool known = fit_pose(view, body, *prior, 0);
  const bool is_first = view.shutter.is_on() && !body.twist_known;
  if (known) find_twist(view, body, *before);
  if (known && !is_first) {
    align(view, body, *body.camera_from_map);
    known = fit_pose(view, body, *body.camera_from_map, 1);
    if (known) find_twist(view, body, *before);
  }
  if (!known) {
    if (body.label == 0) leave_map(body, *before);  // another body moves on while it is lost
    return give_up(view, body, with_landmark >= 2 * view.options.motion.min_inliers);
  }
  set_motion(view, body, *before);
}

Pose follow_twist(const FrameView& view, TrackedBody& body, const Pose& expected) {
  if (!view.shutter.is_on() || !body.twist_known || view.step_ns <= 0) return expected;
  RigidMotionOptions options = view.options.motion;
  options.min_share = std::min(options.min_share, kShareOfMiddleRows);
  const Pose before = *body.camera_from_map;
  Pose pose = expected;
  int agreed = 0;
  for (int round = 0; round < kMostRounds; ++round) {
    const Sightings sightings = sightings_of(body, pose);
    RandomStream random(view.seed, "rolling_shutter", view.frame, body.label);
    const auto fit = fit_rigid_motion(sightings.of, view.camera, pose, options, random);
    if (!fit || fit->inliers <= agreed) break;
    agreed = fit->inliers;
    if (!fit_twist(view, body, fit->camera_from_body, before, sightings, fit->inlier)) break;
    pose = *body.camera_from_map;
  }
  body.camera_from_map = before;
  return pose;
}

void find_twist(const FrameView& view, TrackedBody& body, const Pose& before) {
  if (!view.shutter.is_on() || view.step_ns <= 0) return;
  if (!body.twist_known) {
    body.twist = mean_twist(view, *body.camera_from_map, before);
    body.twist_known = true;
    return begin_landmarks_anew(view, body);
  }
  const Sightings sightings = sightings_of(body, *body.camera_from_map);
  fit_twist(view, body, *body.camera_from_map, before, sightings,
            std::vector<bool>(sightings.of.size(), true));
}

void set_motion(const FrameView& view, TrackedBody& body, const Pose& before) {
  body.motion = *body.camera_from_map * before.inverse();
  body.motion->rotation.normalize();
  body.motion_ns = view.step_ns;
}

}  // namespace uniquadric
