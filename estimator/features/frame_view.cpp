#include "estimator/features/frame_view.h"

#include "estimator/observation/ideal_ray.h"

namespace uniquadric {
namespace {

constexpr int kRounds = 2;               // of depth and place in turn: depth changes little along the way
constexpr double kUnknownDepth_m = 1e3;  // so that what turns is moved, and what shifts is not

// What is known of a track's depth before it is measured; nothing of a new one.
std::optional<double> expected_depth_m(const PointTrack& track, const TrackedBody& body) {
  if (track.landmark && body.camera_from_map && track.map == body.map) {
    const double depth_m = (*body.camera_from_map * track.landmark->point).z();
    if (depth_m > 0) return depth_m;
  }
  return track.depth ? std::optional(track.depth->depth_m) : std::nullopt;
}

}  // namespace

bool FrameView::place(PointTrack& track, const Eigen::Vector2d& pixel, const TrackedBody& body) const {
  if (!place_roughly(track, pixel, body)) return false;
  track.depth = fit_plane_depth(depth, regions.labels, track.at_stamp, options.depth, noise);
  return true;
}

bool FrameView::place_roughly(PointTrack& track, const Eigen::Vector2d& pixel,
                              const TrackedBody& body) const {
  const auto place = at_stamp(track, pixel, body);
  const auto ray = place ? lens.unproject(*place) : std::nullopt;
  if (!ray) return false;
  track.pixel = pixel;
  track.at_stamp = *place;
  track.undistorted = ideal_pixel(camera, *ray);
  track.depth = quick_depth(*place);
  return true;
}

std::optional<PlaneDepth> FrameView::quick_depth(const Eigen::Vector2d& pixel) const {
  PlaneDepthOptions quick = options.depth;
  quick.half_wide_px = 0;
  return fit_plane_depth(depth, regions.labels, pixel, quick, noise);
}

std::optional<Eigen::Vector2d> FrameView::at_stamp(const PointTrack& track, const Eigen::Vector2d& pixel,
                                                   const TrackedBody& body) const {
  if (!shutter.is_on()) return pixel;
  auto depth_m = expected_depth_m(track, body);
  std::optional<Eigen::Vector2d> place = pixel;
  for (int round = 0; place && round < kRounds; ++round) {
    if (round > 0 || !depth_m)
      if (const auto measured = quick_depth(*place)) depth_m = measured->depth_m;
    place = shutter.at_stamp(pixel, depth_m.value_or(kUnknownDepth_m), body.twist);
  }
  return place;
}

bool FrameView::belongs(int label, const PointTrack& track) const {
  const auto hint = hints.find(label);
  if (hint == hints.end() || !hint->second.envelope || !track.depth) return true;
  return hint->second.envelope(seen_point(camera, track, options.motion.pixel_sigma).point);
}

int FrameView::most_tracks(int label) const {
  return label == 0 ? options.gallery.background_tracks : options.gallery.body_tracks;
}

}  // namespace uniquadric
