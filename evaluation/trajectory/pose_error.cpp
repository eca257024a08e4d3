#include "evaluation/trajectory/pose_error.h"

namespace uniquadric {
namespace {

PoseError size_of(const Pose& error) {
  return {error.translation.norm(), rotation_angle(error.rotation.toRotationMatrix())};
}

Pose relative_difference(const Pose& reference_i, const Pose& reference_j, const Pose& estimate_i,
                         const Pose& estimate_j) {
  return (reference_i.inverse() * reference_j).inverse() * (estimate_i.inverse() * estimate_j);
}

double distance_from_identity(const Pose& pose) {
  return (pose.matrix() - Eigen::Matrix4d::Identity()).norm();
}

}  // namespace

PoseError absolute_error(const Pose& reference, const Pose& estimate) {
  const Eigen::Matrix3d R =
      estimate.rotation.toRotationMatrix().transpose() * reference.rotation.toRotationMatrix();
  return {(estimate.translation - reference.translation).norm(), rotation_angle(R)};
}

PoseError relative_error(const Pose& reference_i, const Pose& reference_j, const Pose& estimate_i,
                         const Pose& estimate_j) {
  return size_of(relative_difference(reference_i, reference_j, estimate_i, estimate_j));
}

PoseError object_motion_error(const Pose& reference_i, const Pose& reference_j, const Pose& estimate_i,
                              const Pose& estimate_j) {
  const Pose reference_motion = reference_j * reference_i.inverse();
  const Pose estimate_motion = estimate_j * estimate_i.inverse();
  return size_of(reference_i.inverse() * (reference_motion.inverse() * estimate_motion * reference_i));
}

double full_relative_error(const Pose& reference_i, const Pose& reference_j, const Pose& estimate_i,
                           const Pose& estimate_j) {
  return distance_from_identity(relative_difference(reference_i, reference_j, estimate_i, estimate_j));
}

double full_absolute_error(const Pose& reference, const Pose& estimate) {
  return distance_from_identity(reference.inverse() * estimate);
}

}  // namespace uniquadric
