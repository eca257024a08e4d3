#include "estimator/factors/reprojection.h"

#include <ceres/sized_cost_function.h>

#include "estimator/factors/pose_block.h"
#include "estimator/factors/pose_jacobian.h"

namespace uniquadric {
namespace {

constexpr double kMinDepth = 0.1;  // m: nearer than any sensor here measures

template <int Rows>  // 2: pixel, 3: pixel and depth
class Reprojection final : public ceres::SizedCostFunction<Rows, 7, 3> {
 public:
  Reprojection(const Camera& camera, const Pose& world_from_camera, const Feature& feature, double sigma_px)
      : focal_(camera.fx / sigma_px, camera.fy / sigma_px),
        pixel_((feature.pixel - Eigen::Vector2d(camera.cx, camera.cy)) / sigma_px),
        depth_m_(feature.depth_m),
        per_depth_(Rows == 3 ? 1 / feature.depth_sigma_m : 0),
        rotation_(world_from_camera.rotation.toRotationMatrix().transpose()),
        camera_(world_from_camera.translation) {}

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const Pose world_from_body = pose_from_block(blocks[0]);
    const Eigen::Map<const Eigen::Vector3d> p_body(blocks[1]);
    const Eigen::Matrix3d R = world_from_body.rotation.toRotationMatrix();
    // The two positions are subtracted first: far from the world's origin no digits are lost.
    const Eigen::Vector3d p = rotation_ * (R * p_body + (world_from_body.translation - camera_));
    const double z = std::max(p.z(), kMinDepth);
    residuals[0] = focal_.x() * p.x() / z - pixel_.x();
    residuals[1] = focal_.y() * p.y() / z - pixel_.y();
    if constexpr (Rows == 3) residuals[2] = (p.z() - depth_m_) * per_depth_;
    if (!jacobians) return true;

    Eigen::Matrix<double, Rows, 3> by_p = Eigen::Matrix<double, Rows, 3>::Zero();
    by_p(0, 0) = focal_.x() / z;
    by_p(1, 1) = focal_.y() / z;
    if (p.z() > kMinDepth) {
      by_p(0, 2) = -focal_.x() * p.x() / (z * z);
      by_p(1, 2) = -focal_.y() * p.y() / (z * z);
    }
    if constexpr (Rows == 3) by_p(2, 2) = per_depth_;
    write_jacobians(by_p * rotation_, R, world_from_body.rotation, p_body, jacobians);
    return true;
  }

 private:
  // by_world: derivative by the point's place in the world.
  static void write_jacobians(const Eigen::Matrix<double, Rows, 3>& by_world, const Eigen::Matrix3d& R,
                              const Eigen::Quaterniond& q, const Eigen::Vector3d& p_body,
                              double** jacobians) {
    const Eigen::Matrix<double, Rows, 3> by_body = by_world * R;
    if (jacobians[0]) {
      // p_body moves by rho + phi x p_body; the translation's columns are by_world itself.
      Eigen::Map<Eigen::Matrix<double, Rows, 7, Eigen::RowMajor>> out(jacobians[0]);
      out.template leftCols<4>().noalias() =
          (-4 * (by_body * skew(p_body))) * quaternion_tangent(q).transpose();
      out.template rightCols<3>() = by_world;
    }
    if (jacobians[1]) Eigen::Map<Eigen::Matrix<double, Rows, 3, Eigen::RowMajor>>{jacobians[1]} = by_body;
  }

  Eigen::Vector2d focal_, pixel_;  // over sigma_px; the pixel from the principal point
  double depth_m_, per_depth_;
  Eigen::Matrix3d rotation_;  // camera from world
  Eigen::Vector3d camera_;    // in the world
};

}  // namespace

std::unique_ptr<ceres::CostFunction> reprojection_factor(const Camera& camera, const Pose& world_from_camera,
                                                         const Feature& feature, double sigma_px) {
  if (feature.depth_m > 0 && feature.depth_sigma_m > 0)
    return std::make_unique<Reprojection<3>>(camera, world_from_camera, feature, sigma_px);
  return std::make_unique<Reprojection<2>>(camera, world_from_camera, feature, sigma_px);
}

}  // namespace uniquadric
