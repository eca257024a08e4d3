#include "estimator/objects/motion_decision.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

namespace uniquadric {
namespace {

double sigmas_off(const Eigen::Vector3d& error, const Eigen::Matrix3d& covariance) {
  return std::sqrt(error.dot(covariance.ldlt().solve(error)));
}

// A turn of the camera carries what it sees along, by its distance.
PoseSigmas camera_share(double distance_m, const MotionDecisionOptions& o) {
  const PoseSigmas& camera = o.camera_sigmas;
  return {std::hypot(camera.translation_m, distance_m * camera.rotation_rad), camera.rotation_rad};
}

// With what all features have in common: the camera's errors, and those by which they creep over the surface.
Matrix6d with_common_errors(Matrix6d covariance, double distance_m, double radius_m,
                            const MotionDecisionOptions& o) {
  const PoseSigmas camera = camera_share(distance_m, o);
  const double shift_m = std::hypot(camera.translation_m, o.surface_sigma_m);
  const double turn_rad = std::hypot(camera.rotation_rad, o.surface_sigma_m / radius_m);
  covariance.diagonal().head<3>().array() += shift_m * shift_m;
  covariance.diagonal().tail<3>().array() += turn_rad * turn_rad;
  return covariance;
}

}  // namespace

void MotionDecision::add(std::int64_t stamp_ns, const Pose& world_from_camera, const Pose& world_from_body,
                         const Matrix6d& covariance, double radius_m) {
  const auto age_s = [&](const Sample& sample) {
    return 1e-9 * static_cast<double>(stamp_ns - sample.stamp_ns);
  };
  while (std::ssize(samples_) >= options_.rest_poses && age_s(samples_.front()) > options_.window_s)
    samples_.pop_front();
  const double distance_m = (world_from_body.translation - world_from_camera.translation).norm();
  const Sample now{stamp_ns, world_from_body, distance_m,
                   with_common_errors(covariance, distance_m, radius_m, options_)};
  std::vector<double> off;
  for (const Sample& then : samples_) {
    const Vector6d error = log_se3(relative_pose(then.world_from_body, now.world_from_body));
    const Matrix6d both = then.covariance + now.covariance;
    off.push_back(std::max(sigmas_off(error.head<3>(), both.topLeftCorner<3, 3>()),
                           sigmas_off(error.tail<3>(), both.bottomRightCorner<3, 3>())));
  }
  samples_.push_back(now);
  if (off.empty()) return;
  std::sort(off.begin(), off.end());
  const bool is_off = off[off.size() / 2] > options_.moving_sigmas;
  const bool is_long =
      age_s(samples_.front()) >= options_.rest_s && std::ssize(samples_) >= options_.rest_poses;
  if (is_off && was_off_)  // twice: one pose may be wrong
    decision_ = ObjectMotion::moving;
  else if (is_long && off.back() < options_.rest_sigmas)
    decision_ = ObjectMotion::at_rest;
  was_off_ = is_off;
}

}  // namespace uniquadric
