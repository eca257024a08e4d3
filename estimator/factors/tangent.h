#pragma once

#include <Eigen/Core>
#include <memory>

#include "core/geometry/camera.h"
#include "core/geometry/pose.h"
#include "estimator/observation/perception.h"

namespace ceres {
class CostFunction;
}

namespace uniquadric {

/// The plane through the camera's centre and a line of its image (pi = P^T l): normal . x + offset_m = 0 in
/// the world, |normal| = 1, the body on the negative side.
struct TangentPlane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitX();
  double offset_m = 0;
  double px_per_m = 1;  ///< pixels across the line per metre across the plane, at the depth it was made for
};

/// Back-projects a support line. depth_m: z of the body's centre in the camera, positive.
TangentPlane tangent_plane(const Camera& camera, const Pose& world_from_camera, const SupportLine& line,
                           double depth_m);

struct TangentOptions {
  int exponents = 1;    // 1 or 3: size of the exponent block
  double sigma_px = 1;  // ours: the noise of a segmenter's boundary
  double smoothing_m =
      1e-4;  // ours: of |x|; keeps the Jacobian continuous, lowers the support by less than it
};

/// Semantic factor by tangency: a support line's plane touches the body,
///   r = (n . t + h_q(a o R^T n) + d) px_per_m / sigma_px,
/// (R, t) = world_from_body * body_from_shape, h_q the superellipsoid's support function. It holds for every
/// body, behind the camera too; the only model is h_q. q = 2 is the dual quadric of Eq. 11: pi^T Q* pi = 0.
/// Not in the paper, whose RotBbox keeps four tangents and takes them for those of an ellipse.
/// Blocks: world_from_body (7), body_from_shape (7), ln a (3), exponents (1 or 3).
std::unique_ptr<ceres::CostFunction> tangent_factor(const TangentPlane& plane,
                                                    const TangentOptions& options = {});

}  // namespace uniquadric
