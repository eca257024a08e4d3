#include "estimator/factors/pose_prior.h"

#include <ceres/sized_cost_function.h>

#include "estimator/factors/pose_block.h"
#include "estimator/factors/pose_jacobian.h"

namespace uniquadric {
namespace {

Matrix6d sqrt_information_of(const PoseSigmas& sigmas) {
  Vector6d diagonal;
  diagonal << Eigen::Vector3d::Constant(1 / sigmas.translation_m),
      Eigen::Vector3d::Constant(1 / sigmas.rotation_rad);
  return diagonal.asDiagonal();
}

class PosePrior final : public ceres::SizedCostFunction<6, 7> {
 public:
  PosePrior(const Pose& prior, const Matrix6d& sqrt_information) : prior_(prior), sqrt_(sqrt_information) {}

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const Pose pose = pose_from_block(blocks[0]);
    const Pose error = relative_pose(prior_, pose);
    Eigen::Map<Vector6d>{residuals} = sqrt_ * log_se3(error);
    if (jacobians && jacobians[0])
      write_pose_jacobian<6>(sqrt_ * log_se3_jacobian(error), pose.rotation, jacobians[0]);
    return true;
  }

 private:
  Pose prior_;
  Matrix6d sqrt_;
};

class RelativePose final : public ceres::SizedCostFunction<6, 7, 7> {
 public:
  RelativePose(const Pose& a_from_b, const PoseSigmas& sigmas)
      : b_from_a_(a_from_b.inverse()), sqrt_(sqrt_information_of(sigmas)) {}

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const Pose a = pose_from_block(blocks[0]), b = pose_from_block(blocks[1]);
    const Pose a_from_b = relative_pose(a, b);
    const Pose error = b_from_a_ * a_from_b;
    Eigen::Map<Vector6d>{residuals} = sqrt_ * log_se3(error);
    if (!jacobians) return true;
    const Matrix6d by_b = sqrt_ * log_se3_jacobian(error);
    if (jacobians[0]) write_pose_jacobian<6>(-by_b * adjoint(a_from_b.inverse()), a.rotation, jacobians[0]);
    if (jacobians[1]) write_pose_jacobian<6>(by_b, b.rotation, jacobians[1]);
    return true;
  }

 private:
  Pose b_from_a_;
  Matrix6d sqrt_;
};

class LandmarkPrior final : public ceres::SizedCostFunction<3, 3> {
 public:
  LandmarkPrior(const Eigen::Vector3d& p0, const Eigen::Matrix3d& sqrt_information)
      : p0_(p0), sqrt_(sqrt_information) {}

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const Eigen::Map<const Eigen::Vector3d> p(blocks[0]);
    Eigen::Map<Eigen::Vector3d>{residuals} = sqrt_ * (p - p0_);
    if (jacobians && jacobians[0])
      Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>{jacobians[0]} = sqrt_;
    return true;
  }

 private:
  Eigen::Vector3d p0_;
  Eigen::Matrix3d sqrt_;
};

}  // namespace

std::unique_ptr<ceres::CostFunction> pose_prior_factor(const Pose& prior, const PoseSigmas& sigmas) {
  return std::make_unique<PosePrior>(prior, sqrt_information_of(sigmas));
}

std::unique_ptr<ceres::CostFunction> pose_prior_factor(const Pose& prior,
                                                       const Eigen::Matrix<double, 6, 6>& sqrt_information) {
  return std::make_unique<PosePrior>(prior, sqrt_information);
}

std::unique_ptr<ceres::CostFunction> relative_pose_factor(const Pose& a_from_b, const PoseSigmas& sigmas) {
  return std::make_unique<RelativePose>(a_from_b, sigmas);
}

std::unique_ptr<ceres::CostFunction> landmark_prior_factor(const Eigen::Vector3d& p0,
                                                           const Eigen::Matrix3d& sqrt_information) {
  return std::make_unique<LandmarkPrior>(p0, sqrt_information);
}

}  // namespace uniquadric
