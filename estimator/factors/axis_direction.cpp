#include "estimator/factors/axis_direction.h"

#include <ceres/sized_cost_function.h>

#include "estimator/factors/pose_block.h"
#include "estimator/factors/pose_jacobian.h"

namespace uniquadric {
namespace {

class AxisDirection final : public ceres::SizedCostFunction<2, 7> {
 public:
  AxisDirection(const Eigen::Vector3d& direction, int axis, double sigma_rad) : direction_(direction) {
    others_.row(0) = Eigen::Vector3d::Unit((axis + 1) % 3).transpose() / sigma_rad;
    others_.row(1) = Eigen::Vector3d::Unit((axis + 2) % 3).transpose() / sigma_rad;
  }

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const Pose body_from_object = pose_from_block(blocks[0]);
    const Eigen::Vector3d in_object = body_from_object.rotation.conjugate() * direction_;
    Eigen::Map<Eigen::Vector2d>{residuals} = others_ * in_object;
    if (!jacobians || !jacobians[0]) return true;
    Eigen::Matrix<double, 2, 6> local = Eigen::Matrix<double, 2, 6>::Zero();
    local.rightCols<3>() = others_ * skew(in_object);
    write_pose_jacobian<2>(local, body_from_object.rotation, jacobians[0]);
    return true;
  }

 private:
  Eigen::Vector3d direction_;
  Eigen::Matrix<double, 2, 3> others_;
};

}  // namespace

std::unique_ptr<ceres::CostFunction> axis_direction_factor(const Eigen::Vector3d& direction, int axis,
                                                           double sigma_rad) {
  return std::make_unique<AxisDirection>(direction, axis, sigma_rad);
}

}  // namespace uniquadric
