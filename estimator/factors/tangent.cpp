#include "estimator/factors/tangent.h"

#include <ceres/sized_cost_function.h>

#include <Eigen/Geometry>
#include <cassert>
#include <cmath>

#include "core/geometry/superquadric.h"
#include "estimator/factors/pose_block.h"
#include "estimator/factors/pose_jacobian.h"
#include "estimator/factors/shape_block.h"

namespace uniquadric {
namespace {

template <int Exponents>
class Tangent final : public ceres::SizedCostFunction<1, 7, 7, 3, Exponents> {
 public:
  Tangent(const TangentPlane& plane, const TangentOptions& options)
      : plane_(plane), weight_(plane.px_per_m / options.sigma_px), smoothing_m_(options.smoothing_m) {}

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const Pose world_from_body = pose_from_block(blocks[0]), body_from_shape = pose_from_block(blocks[1]);
    const Eigen::Vector3d in_body = world_from_body.rotation.conjugate() * plane_.normal;
    const Eigen::Vector3d in_shape = body_from_shape.rotation.conjugate() * in_body;
    const auto h = superellipsoid_support_derivatives(
        axes_from_block(blocks[2]), exponents_from_block(blocks[3], Exponents), in_shape, smoothing_m_);
    const double distance = plane_.normal.dot(world_from_body.translation) + plane_.offset_m +
                            in_body.dot(body_from_shape.translation) + h.value;
    residuals[0] = weight_ * distance;
    if (!std::isfinite(residuals[0]) || !are_numbers(h)) return false;  // the solver takes a shorter step
    if (!jacobians) return true;

    // The normal turns by -phi x n; the point it supports, in the frame that turns, takes it up.
    if (jacobians[0]) {
      const Eigen::Vector3d support = body_from_shape * h.by_normal;
      write_pose(in_body, support, world_from_body, jacobians[0]);
    }
    if (jacobians[1]) write_pose(in_shape, h.by_normal, body_from_shape, jacobians[1]);
    if (jacobians[2]) Eigen::Map<Eigen::Vector3d>{jacobians[2]} = weight_ * h.by_log_axes;
    if (jacobians[3]) write_exponents(h, blocks[3], jacobians[3]);
    return true;
  }

 private:
  // With the weight on them, as they are written.
  bool are_numbers(const SupportDerivatives& h) const {
    return (weight_ * h.by_normal).allFinite() && (weight_ * h.by_log_axes).allFinite() &&
           std::isfinite(weight_ * h.by_outline) && std::isfinite(weight_ * h.by_profile);
  }

  void write_pose(const Eigen::Vector3d& normal, const Eigen::Vector3d& support, const Pose& pose,
                  double* out) const {
    Eigen::Matrix<double, 1, 6> local;
    local << normal.transpose(), support.cross(normal).transpose();
    write_pose_jacobian<1>(weight_ * local, pose.rotation, out);
  }

  void write_exponents(const SupportDerivatives& h, const double* block, double* out) const {
    if constexpr (Exponents == 1) {
      out[0] = weight_ * (h.by_outline + h.by_profile) * exponent_slope(block[0]);
    } else {
      out[0] = weight_ * h.by_outline * exponent_slope(block[0]);
      out[1] = h.upper ? weight_ * h.by_profile * exponent_slope(block[1]) : 0;
      out[2] = h.upper ? 0 : weight_ * h.by_profile * exponent_slope(block[2]);
    }
  }

  TangentPlane plane_;
  double weight_, smoothing_m_;
};

}  // namespace

TangentPlane tangent_plane(const Camera& camera, const Pose& world_from_camera, const SupportLine& line,
                           double depth_m) {
  // K^T l: for a point (x, y, z) of the camera frame, l . pixel = (K^T l) . (x, y, z) / z.
  const Eigen::Vector3d l(line.normal.x(), line.normal.y(), -line.offset_px);
  const Eigen::Vector3d in_camera = camera.matrix().transpose() * l;
  const Eigen::Vector3d normal = world_from_camera.rotation * in_camera.normalized();
  return {normal, -normal.dot(world_from_camera.translation), in_camera.norm() / depth_m};
}

std::unique_ptr<ceres::CostFunction> tangent_factor(const TangentPlane& plane,
                                                    const TangentOptions& options) {
  assert(options.exponents == 1 || options.exponents == 3);
  if (options.exponents == 3) return std::make_unique<Tangent<3>>(plane, options);
  return std::make_unique<Tangent<1>>(plane, options);
}

}  // namespace uniquadric
