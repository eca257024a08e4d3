#include "estimator/features/tracked_body.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <utility>

#include "estimator/observation/ideal_ray.h"

namespace uniquadric {
namespace {

constexpr double kMinNormalVariance = 1e-5;  // rad^2

void carry(PointTrack& track, int map, const Pose& map_from_present) {
  const Eigen::Matrix3d R = map_from_present.rotation.toRotationMatrix();
  track.map = map;
  if (track.landmark) {
    track.landmark->point = map_from_present * track.landmark->point;
    track.landmark->information = R * track.landmark->information * R.transpose();
    track.landmark->normal_sum = R * track.landmark->normal_sum;
  }
  if (track.anchor)
    track.anchor->camera_from_map = track.anchor->camera_from_map * map_from_present.inverse();
}

// The normal of the surface in the camera frame, its length the inverse of its variance [1/rad^2].
Eigen::Vector3d weighted_normal(const Camera& camera, const PointTrack& track) {
  const double sigma_rad = camera.fx * track.depth->depth_m * track.depth->slope_sigma_per_px;
  return surface_normal(camera, track.undistorted, *track.depth) /
         (sigma_rad * sigma_rad + kMinNormalVariance);
}

}  // namespace

std::optional<Pose> predicted_pose(const TrackedBody& body, std::int64_t step_ns) {
  if (!body.camera_from_map) return std::nullopt;
  if (!body.motion || body.motion_ns <= 0) return body.camera_from_map;
  const double steps = static_cast<double>(step_ns) / static_cast<double>(body.motion_ns);
  Pose pose = exp_se3(steps * log_se3(*body.motion)) * *body.camera_from_map;
  pose.rotation.normalize();
  return pose;
}

SeenPoint seen_point(const Camera& camera, const PointTrack& track, double pixel_sigma) {
  const double z = track.depth->depth_m;
  const Eigen::Vector3d ray = ideal_ray(camera, track.undistorted);
  Eigen::Matrix3d J = Eigen::Matrix3d::Zero();  // by pixel x, y in sigmas, then depth in sigmas
  J(0, 0) = z / camera.fx * pixel_sigma;
  J(1, 1) = z / camera.fy * pixel_sigma;
  J.col(2) = ray * track.depth->sigma_m;
  const Eigen::Matrix3d inverse = J.inverse();
  return {z * ray, inverse.transpose() * inverse};
}

void add_sighting(PointTrack& track, const Camera& camera, const Pose& camera_from_map, double pixel_sigma,
                  int most) {
  const SeenPoint seen = seen_point(camera, track, pixel_sigma);
  const Eigen::Matrix3d R = camera_from_map.rotation.toRotationMatrix();
  const Eigen::Vector3d point = camera_from_map.inverse() * seen.point;
  const Eigen::Matrix3d information = R.transpose() * seen.information * R;
  const Eigen::Vector3d normal = R.transpose() * weighted_normal(camera, track);
  if (!track.landmark) {
    track.landmark = TrackLandmark{point, information, normal, 1};
    return;
  }
  TrackLandmark& landmark = *track.landmark;
  if (landmark.sightings >= most) return;
  const Eigen::Matrix3d sum = landmark.information + information;
  landmark.point += sum.ldlt().solve(information * (point - landmark.point));
  landmark.information = sum;
  landmark.normal_sum += normal;
  ++landmark.sightings;
}

void retire(TrackedBody& body, PointTrack track, int min_sightings, int most_tracks) {
  if (!track.landmark || !track.anchor || track.landmark->sightings < min_sightings) return;
  if (most_tracks <= 0) return;
  if (std::ssize(body.gallery) >= most_tracks) body.gallery.erase(body.gallery.begin());
  track.missed = track.tries = 0;
  body.gallery.push_back(std::move(track));
}

void join_map(TrackedBody& body, int map, const Pose& map_from_present) {
  for (auto* tracks : {&body.tracks, &body.gallery})
    for (auto& track : *tracks)
      if (track.map == body.map) carry(track, map, map_from_present);
  if (body.camera_from_map) body.camera_from_map = *body.camera_from_map * map_from_present.inverse();
  body.map = map;
}

}  // namespace uniquadric
