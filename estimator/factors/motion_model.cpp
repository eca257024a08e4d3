#include "estimator/factors/motion_model.h"

#include <ceres/sized_cost_function.h>

#include <Eigen/LU>
#include <cmath>

#include "estimator/factors/pose_block.h"
#include "estimator/factors/pose_jacobian.h"

namespace uniquadric {
namespace {

// The prediction's own perturbation by those of the two poses it comes from.
struct Prediction {
  Pose pose;
  Matrix6d by_t0, by_t1;
};

Prediction predict_straight(const Pose& at_t0, const Pose& at_t1, double ratio) {
  const Eigen::Vector3d turn = log_so3(at_t0.rotation.conjugate() * at_t1.rotation);
  Prediction p{predict_pose(at_t0, at_t1, ratio, MotionModel::straight), Matrix6d::Zero(), Matrix6d::Zero()};
  const Eigen::Matrix3d predicted_from_world = p.pose.rotation.toRotationMatrix().transpose();
  const Eigen::Matrix3d R0 = at_t0.rotation.toRotationMatrix(), R1 = at_t1.rotation.toRotationMatrix();
  // R_hat = R1 Exp(ratio turn)
  const Eigen::Matrix3d by_turn = ratio * right_jacobian_so3(ratio * turn) * inverse_right_jacobian_so3(turn);
  p.by_t0.topLeftCorner<3, 3>() = -ratio * predicted_from_world * R0;
  p.by_t1.topLeftCorner<3, 3>() = (1 + ratio) * predicted_from_world * R1;
  p.by_t0.bottomRightCorner<3, 3>() = -by_turn * R1.transpose() * R0;
  p.by_t1.bottomRightCorner<3, 3>() = by_turn + predicted_from_world * R1;
  return p;
}

Prediction predict_screw(const Pose& at_t0, const Pose& at_t1, double ratio) {
  const Pose step = relative_pose(at_t0, at_t1);
  const Pose next = exp_se3(ratio * log_se3(step));
  // next = exp(ratio log(step)); the right Jacobian of exp is the inverse of that of log.
  const Matrix6d by_step = ratio * log_se3_jacobian(next).inverse() * log_se3_jacobian(step);
  return {at_t1 * next, -by_step * adjoint(step.inverse()), by_step + adjoint(next.inverse())};
}

class ConstantVelocity final : public ceres::SizedCostFunction<6, 7, 7, 7> {
 public:
  ConstantVelocity(double ratio, MotionModel model, const PoseSigmas& sigmas) : ratio_(ratio), model_(model) {
    weights_ << Eigen::Vector3d::Constant(1 / sigmas.translation_m),
        Eigen::Vector3d::Constant(1 / sigmas.rotation_rad);
  }

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const Pose at_t0 = pose_from_block(blocks[0]), at_t1 = pose_from_block(blocks[1]);
    const Pose at_t2 = pose_from_block(blocks[2]);
    const Prediction predicted = model_ == MotionModel::screw ? predict_screw(at_t0, at_t1, ratio_)
                                                              : predict_straight(at_t0, at_t1, ratio_);
    const Pose error = relative_pose(predicted.pose, at_t2);
    Eigen::Map<Vector6d>{residuals} = weights_.cwiseProduct(log_se3(error));
    if (!jacobians) return true;
    const Matrix6d by_t2 = weights_.asDiagonal() * log_se3_jacobian(error);
    const Matrix6d by_prediction = -by_t2 * adjoint(error.inverse());
    if (jacobians[0]) write_pose_jacobian<6>(by_prediction * predicted.by_t0, at_t0.rotation, jacobians[0]);
    if (jacobians[1]) write_pose_jacobian<6>(by_prediction * predicted.by_t1, at_t1.rotation, jacobians[1]);
    if (jacobians[2]) write_pose_jacobian<6>(by_t2, at_t2.rotation, jacobians[2]);
    return true;
  }

 private:
  double ratio_;
  MotionModel model_;
  Vector6d weights_;
};

}  // namespace

Pose predict_pose(const Pose& at_t0, const Pose& at_t1, double ratio, MotionModel model) {
  if (model == MotionModel::screw) return at_t1 * exp_se3(ratio * log_se3(relative_pose(at_t0, at_t1)));
  return interpolate(at_t0, at_t1, 1 + ratio);
}

PoseSigmas prediction_sigmas(double step_before_s, double step_s, const MotionNoise& noise) {
  const double seconds = step_s * std::sqrt((step_before_s + step_s) / 3);
  return {noise.acceleration * seconds, noise.angular_acceleration * seconds};
}

std::unique_ptr<ceres::CostFunction> motion_model_factor(double ratio, MotionModel model,
                                                         const PoseSigmas& sigmas) {
  return std::make_unique<ConstantVelocity>(ratio, model, sigmas);
}

}  // namespace uniquadric
