#include "estimator/ego/map_locator.h"

#include <algorithm>

#include "estimator/features/rolling_shutter.h"

namespace uniquadric {
namespace {

constexpr int kRowRounds = 3;            // of a pose and what moves its rows, in turn
constexpr double kRowDepthShare = 0.05;  // of depth, its sigma where it was looked up at the row's place

}  // namespace

std::vector<PointSighting> sightings_of(const EgoMap& map, const std::vector<Feature>& features) {
  std::vector<PointSighting> sightings;
  for (const Feature& f : features)
    if (const auto point = map.points.find(f.track); point != map.points.end())
      sightings.push_back({point->second.position, f.pixel, f.depth_m, f.depth_sigma_m});
  return sightings;
}

std::optional<RigidMotion> MapLocator::locate(const EgoMap& map, const std::vector<Feature>& features,
                                              const std::optional<Pose>& prior, std::int64_t frame) const {
  RandomStream random(seed, "ego", frame);
  return fit_rigid_motion(sightings_of(map, features), camera, prior, pose, random);
}

std::optional<Pose> MapLocator::locate(const EgoMap& map, const FramePose& frame, const Pose& prior) const {
  if (frame.presumed_twist) return locate_rows(map, frame, prior);
  const auto fit = locate(map, frame.features, prior, frame.frame);
  return fit ? std::optional(fit->camera_from_body) : std::nullopt;
}

// A frame whose features are at their rows: its pose and the background's twist in turn.
std::optional<Pose> MapLocator::locate_rows(const EgoMap& map, const FramePose& frame,
                                            const Pose& prior) const {
  const RollingShutter shutter(camera, rolling_shutter_s);
  MovingPose moving{prior, *frame.presumed_twist};
  for (int round = 0; round < kRowRounds; ++round) {
    std::vector<Feature> features;
    for (Feature f : frame.features)
      if (f.depth_m > 0 && map.points.contains(f.track)) features.push_back(f);
    std::vector<double> delays_s, agreed_s;
    for (Feature& f : features) {
      delays_s.push_back(shutter.delay_s(f.pixel.y()));
      f.pixel = shutter.at_stamp(f.pixel, f.depth_m, moving.twist).value_or(f.pixel);
      f.depth_sigma_m = std::max(f.depth_sigma_m, kRowDepthShare * f.depth_m);
    }
    const auto fit = locate(map, features, moving.camera_from_body, frame.frame);
    if (!fit) return std::nullopt;
    std::vector<PointSighting> agreed;
    const auto sightings = sightings_of(map, features);
    for (std::size_t i = 0; i < sightings.size(); ++i)
      if (fit->inlier[i]) agreed.push_back(sightings[i]), agreed_s.push_back(delays_s[i]);
    const auto refined = fit_moving_pose(agreed, agreed_s, camera, {fit->camera_from_body, moving.twist},
                                         *frame.presumed_twist, pose.pixel_sigma, {});
    if (!refined) return fit->camera_from_body;
    moving = *refined;
  }
  return moving.camera_from_body;
}

Pose MapLocator::found_again(const EgoMap& map, const FramePose& frame) const {
  const Keyframe& keyframe = map.keyframes[frame.keyframe];
  const Pose expected = frame.camera_from_keyframe * keyframe.camera_from_world;
  if (keyframe.frame == frame.frame || frame.features.empty()) return expected;
  const auto fit = locate(map, frame.features, expected, frame.frame);
  return fit ? fit->camera_from_body : expected;
}

}  // namespace uniquadric
