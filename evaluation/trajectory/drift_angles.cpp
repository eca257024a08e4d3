#include "evaluation/trajectory/drift_angles.h"

#include <array>
#include <cmath>
#include <numbers>

namespace uniquadric {
namespace {
using std::numbers::pi;

// The turn's angles, of all that mean the same the ones nearest to `previous`: full turns added, and beyond
// a pitch of a right angle the second of the two solutions.
Eigen::Vector3d unwrapped(const Eigen::Vector3d& angles, const Eigen::Vector3d& previous) {
  const auto near = [&](const Eigen::Vector3d& a) -> Eigen::Vector3d {
    return a - 2 * pi * ((a - previous) / (2 * pi)).array().round().matrix();
  };
  const Eigen::Vector3d first = near(angles);
  const Eigen::Vector3d second = near({angles.x() + pi, pi - angles.y(), angles.z() + pi});
  return (second - previous).squaredNorm() < (first - previous).squaredNorm() ? second : first;
}

void take(AngleExtremes& extremes, double angle_rad, std::size_t index) {
  if (angle_rad < extremes.min_rad) extremes.min_rad = angle_rad, extremes.min_index = index;
  if (angle_rad > extremes.max_rad) extremes.max_rad = angle_rad, extremes.max_index = index;
}

}  // namespace

Eigen::Vector3d roll_pitch_yaw(const Eigen::Matrix3d& R) {
  return {std::atan2(R(2, 1), R(2, 2)), std::atan2(-R(2, 0), std::hypot(R(2, 1), R(2, 2))),
          std::atan2(R(1, 0), R(0, 0))};
}

std::optional<DriftAngles> drift_angles(const PosePairs& poses) {
  if (poses.size() == 0) return std::nullopt;
  DriftAngles result;
  Eigen::Vector3d angles = Eigen::Vector3d::Zero();
  for (std::size_t k = 1; k < poses.size(); ++k) {
    const Eigen::Quaterniond reference =
        poses.reference[0].rotation.conjugate() * poses.reference[k].rotation;
    const Eigen::Quaterniond estimate = poses.estimate[0].rotation.conjugate() * poses.estimate[k].rotation;
    const Eigen::Matrix3d error = (reference.conjugate() * estimate).toRotationMatrix();
    angles = unwrapped(roll_pitch_yaw(error), angles);
    take(result.roll, angles.x(), k);
    take(result.pitch, angles.y(), k);
    take(result.yaw, angles.z(), k);
  }
  return result;
}

}  // namespace uniquadric
