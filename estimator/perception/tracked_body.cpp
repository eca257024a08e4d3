#include "estimator/perception/tracked_body.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace uniquadric {

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
  const Eigen::Vector3d ray((track.undistorted.x() - camera.cx) / camera.fx,
                            (track.undistorted.y() - camera.cy) / camera.fy, 1);
  Eigen::Matrix3d J = Eigen::Matrix3d::Zero();  // by pixel x, y in sigmas, then depth in sigmas
  J(0, 0) = z / camera.fx * pixel_sigma;
  J(1, 1) = z / camera.fy * pixel_sigma;
  J.col(2) = ray * track.depth->sigma_m;
  const Eigen::Matrix3d inverse = J.inverse();
  return {z * ray, inverse.transpose() * inverse};
}

void add_sighting(std::optional<Landmark>& landmark, const SeenPoint& seen, const Pose& camera_from_map,
                  int most) {
  const Eigen::Matrix3d R = camera_from_map.rotation.toRotationMatrix();
  const Eigen::Vector3d point = camera_from_map.inverse() * seen.point;
  const Eigen::Matrix3d information = R.transpose() * seen.information * R;
  if (!landmark) {
    landmark = Landmark{point, information, 1};
    return;
  }
  if (landmark->sightings >= most) return;
  const Eigen::Matrix3d sum = landmark->information + information;
  landmark->point += sum.ldlt().solve(information * (point - landmark->point));
  landmark->information = sum;
  ++landmark->sightings;
}

}  // namespace uniquadric
