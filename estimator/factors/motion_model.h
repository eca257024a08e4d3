#pragma once

#include <memory>

#include "core/geometry/pose.h"
#include "estimator/factors/pose_prior.h"

namespace uniquadric {

/// What moves at constant velocity.
enum class MotionModel {
  straight,  ///< the frame's origin on a line, the rotation apart: bodies that fly, fall, roll or slide
  screw,     ///< the twist: vehicles and hinges. Does not depend on where in the body the frame lies
};

/// White noise of the acceleration, as densities; it grows into the sigmas of a prediction with the time
/// steps.
struct MotionNoise {
  double acceleration = 1.0;          // ours: m/s^2 per sqrt(Hz)
  double angular_acceleration = 4.0;  // ours: rad/s^2 per sqrt(Hz)
};

/// Pose at constant velocity, `ratio` = (t2 - t1) / (t1 - t0) steps after t1. (Eq. 7's T_hat)
Pose predict_pose(const Pose& at_t0, const Pose& at_t1, double ratio, MotionModel model);

/// Sigmas of a pose predicted over `step_s` from the velocity of the `step_before_s` before it: white noise
/// of density n on the acceleration gives n step_s sqrt((step_before_s + step_s) / 3).
PoseSigmas prediction_sigmas(double step_before_s, double step_s, const MotionNoise& noise);

/// Motion model (Eq. 7): r = Log(T_hat^-1 T2), weighted apart, T_hat predicted from T0 and T1 over the true
/// time steps. The paper prints the difference of two matrices. Blocks: world_from_body at t0, t1, t2 (7
/// each).
std::unique_ptr<ceres::CostFunction> motion_model_factor(double ratio, MotionModel model,
                                                         const PoseSigmas& sigmas);

}  // namespace uniquadric
