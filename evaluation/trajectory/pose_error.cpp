#include "evaluation/trajectory/pose_error.h"

namespace uniquadric {
namespace {

PoseError size_of(const Pose& error) {
  return {error.translation.norm(), rotation_angle(error.rotation.toRotationMatrix())};
}

// a^-1 b, exactly the identity for the same numbers: a perfect estimate has no error at all.
Pose difference(const Pose& a, const Pose& b) {
  if (same_pose(a, b)) return {};
  return relative_pose(a, b);
}

Pose relative_difference(const Pose& reference_i, const Pose& reference_j, const Pose& estimate_i,
                         const Pose& estimate_j) {
  return difference(relative_pose(reference_i, reference_j), relative_pose(estimate_i, estimate_j));
}

double distance_from_identity(const Pose& pose) {
  return (pose.matrix() - Eigen::Matrix4d::Identity()).norm();
}

}  // namespace

bool same_pose(const Pose& a, const Pose& b) {
  return a.translation == b.translation && a.rotation.coeffs() == b.rotation.coeffs();
}

std::vector<double> path_lengths_m(const std::vector<Pose>& poses) {
  std::vector<double> along(poses.empty() ? 0 : 1);
  for (std::size_t i = 1; i < poses.size(); ++i)
    along.push_back(along.back() + (poses[i].translation - poses[i - 1].translation).norm());
  return along;
}

double absolute_distance_m(const Pose& reference, const Pose& estimate) {
  return (estimate.translation - reference.translation).norm();
}

double absolute_angle_rad(const Pose& reference, const Pose& estimate) {
  return rotation_angle(estimate.rotation.toRotationMatrix().transpose() *
                        reference.rotation.toRotationMatrix());
}

PoseError absolute_error(const Pose& reference, const Pose& estimate) {
  return {absolute_distance_m(reference, estimate), absolute_angle_rad(reference, estimate)};
}

PoseError relative_error(const Pose& reference_i, const Pose& reference_j, const Pose& estimate_i,
                         const Pose& estimate_j) {
  return size_of(relative_difference(reference_i, reference_j, estimate_i, estimate_j));
}

PoseError object_motion_error(const Pose& reference_i, const Pose& reference_j, const Pose& estimate_i,
                              const Pose& estimate_j) {
  // L^-1 H_ref^-1 H_est L with H_ref L = Q_j and H_est = P_j P_i^-1, L = Q_i: no product that has to cancel.
  return size_of(difference(reference_j, estimate_j) * difference(estimate_i, reference_i));
}

double full_relative_error(const Pose& reference_i, const Pose& reference_j, const Pose& estimate_i,
                           const Pose& estimate_j) {
  return distance_from_identity(relative_difference(reference_i, reference_j, estimate_i, estimate_j));
}

double full_absolute_error(const Pose& reference, const Pose& estimate) {
  return distance_from_identity(difference(reference, estimate));
}

}  // namespace uniquadric
