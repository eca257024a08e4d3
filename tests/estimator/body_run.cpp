#include "body_run.h"

#include <algorithm>
#include <cmath>

namespace uniquadric {
namespace {

Pose arc_camera(double t) {
  const double angle = -0.6 + 0.1 * t;
  return looking_at({2.2 * std::sin(angle), -2.2 * std::cos(angle), 1.6}, {0, 0, 1});
}

}  // namespace

Eigen::Vector3d by_size(Eigen::Vector3d axes) {
  std::sort(axes.begin(), axes.end());
  return axes;
}

Pose looking_at(const Eigen::Vector3d& from, const Eigen::Vector3d& at) {
  const Eigen::Vector3d z = (at - from).normalized(), x = z.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d R;
  R << x, z.cross(x), z;
  return {Eigen::Quaterniond(R), from};
}

Pose tumbling(double t) {
  const Eigen::Vector3d axis(0.3, 0.2, 1), wander(std::sin(t), std::cos(0.8 * t), 0.5 * std::sin(2 * t));
  return {exp_so3(0.6 * t * axis.normalized()), Eigen::Vector3d(0, 0, 1) + 0.2 * wander};
}

SyntheticOptions three_seconds() {
  SyntheticOptions options;
  options.world_from_camera = arc_camera;
  return options;
}

Errors largest_errors(const SyntheticPerception& perception, const SyntheticBody& body,
                      const SyntheticOptions& options, double from_s, const BodyOptions& body_options) {
  const Tracks truth = synthetic_truth({body}, options);
  BodyEstimator estimator(1, perception.camera, body_options, 1);
  Errors errors;
  for (std::size_t i = 0; i < perception.frames.size(); ++i) {
    const auto& bodies = perception.frames[i].bodies;
    const auto state = estimator.step(perception.frames[i], bodies.empty() ? nullptr : &bodies[0]);
    if (!state || static_cast<double>(i) < from_s * options.rate_hz) continue;
    const Pose object = state->world_from_body * state->shape.body_from_object;
    const Ellipsoid& expected = truth.objects[0].states[i].ellipsoid;
    const auto raise = [](double& largest, double value) { largest = std::max(largest, value); };
    raise(errors.translation_m, (object.translation - expected.world_from_object.translation).norm());
    raise(errors.rotation_rad, object.rotation.angularDistance(expected.world_from_object.rotation));
    raise(errors.axes_m,
          (by_size(state->shape.semi_axes_m) - by_size(expected.semi_axes_m)).cwiseAbs().maxCoeff());
    ++errors.frames;
  }
  return errors;
}

Errors largest_errors(const SyntheticBody& body, const SyntheticOptions& options, double from_s,
                      const BodyOptions& body_options) {
  return largest_errors(synthetic_perception({body}, options), body, options, from_s, body_options);
}

}  // namespace uniquadric
