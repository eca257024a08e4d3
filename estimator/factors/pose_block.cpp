#include "estimator/factors/pose_block.h"

#include <ceres/manifold.h>

#include <Eigen/Geometry>

#include "estimator/factors/pose_jacobian.h"

namespace uniquadric {
namespace {

using Matrix76 = Eigen::Matrix<double, 7, 6, Eigen::RowMajor>;
using Matrix67 = Eigen::Matrix<double, 6, 7, Eigen::RowMajor>;

class PoseManifold final : public ceres::Manifold {
 public:
  int AmbientSize() const override { return 7; }
  int TangentSize() const override { return 6; }

  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override {
    const Pose pose = pose_from_block(x);
    const Eigen::Map<const Vector6d> d(delta);
    const PoseBlock block = pose_block(perturbed(pose, d));
    std::copy(block.begin(), block.end(), x_plus_delta);
    return true;
  }

  bool PlusJacobian(const double* x, double* jacobian) const override {
    const Eigen::Quaterniond q = pose_from_block(x).rotation;
    Eigen::Map<Matrix76> J(jacobian);
    J.setZero();
    J.topRightCorner<4, 3>() = quaternion_tangent(q);
    J.bottomLeftCorner<3, 3>() = q.toRotationMatrix();
    return true;
  }

  bool Minus(const double* y, const double* x, double* y_minus_x) const override {
    const Pose x_from_y = relative_pose(pose_from_block(x), pose_from_block(y));
    Eigen::Map<Vector6d> d(y_minus_x);
    d << x_from_y.translation, log_so3(x_from_y.rotation);
    return true;
  }

  bool MinusJacobian(const double* x, double* jacobian) const override {
    const Eigen::Quaterniond q = pose_from_block(x).rotation;
    Eigen::Map<Matrix67> J(jacobian);
    J.setZero();
    J.bottomLeftCorner<3, 4>() = 4 * quaternion_tangent(q).transpose();
    J.topRightCorner<3, 3>() = q.toRotationMatrix().transpose();
    return true;
  }
};

}  // namespace

PoseBlock pose_block(const Pose& pose) {
  const Eigen::Quaterniond& q = pose.rotation;
  const Eigen::Vector3d& t = pose.translation;
  return {q.x(), q.y(), q.z(), q.w(), t.x(), t.y(), t.z()};
}

Pose pose_from_block(const double* block) {
  return {Eigen::Quaterniond(block[3], block[0], block[1], block[2]),
          Eigen::Vector3d(block[4], block[5], block[6])};
}

std::unique_ptr<ceres::Manifold> pose_manifold() {
  return std::make_unique<PoseManifold>();
}

}  // namespace uniquadric
