#pragma once

#include <memory>

#include "core/geometry/camera.h"
#include "core/geometry/ellipsoid.h"
#include "core/geometry/pose.h"

namespace ceres {
class CostFunction;
}

namespace uniquadric {

enum class ConicResidual {
  vector,   ///< five numbers whose squares sum to 2 e_B to second order
  literal,  ///< sqrt(2 e_B): one number, whose Jacobian is undefined at its minimum (we give zero)
};

struct ConicOptions {
  ConicResidual residual = ConicResidual::vector;  // ours; Eq. 14 squares a distance that is square already
  double sigma = 0.02;  // ours: relative, e.g. 2 px on an ellipse of 50 px (see conic_sigma)
};

/// The sigma of `ConicOptions` that an outline uncertain by sigma_px has.
double conic_sigma(const Ellipse& observed, double sigma_px);

/// Bhattacharyya distance of two ellipses taken as Gaussians (Eq. 14).
double bhattacharyya_distance(const Ellipse& a, const Ellipse& b);

/// Length of the residual, before it is divided by sigma, where the body has no elliptical outline.
inline constexpr double kNoOutlineResidual = 5;

/// Semantic factor of a RotBbox, or of an upright box as an ellipse of angle 0 (Eq. 11, 13, 14): the outline
/// of the quadric world_from_body * body_from_shape, axes a, against the observed ellipse.
///   vector: r = [ W (mu - mu_obs) / 2 ; vec(log(W Sigma W)) / (2 sqrt 2) ] / sigma, W = Sigma_obs^-1/2, vec
///   being (xx, sqrt 2 xy, yy); literal: r = sqrt(2 e_B) / sigma.
/// Blocks: world_from_body (7), body_from_shape (7), ln a (3). A quadric fixed in the world is the same with
/// world_from_body = identity, held constant.
/// Where the outline is no ellipse (as in `project`: the body crosses the principal plane, or lies behind it)
/// the residual is the constant kNoOutlineResidual / sigma with a zero Jacobian: a robust loss drops it, and
/// a step into such a state is refused since its cost is high.
std::unique_ptr<ceres::CostFunction> conic_factor(const Camera& camera, const Pose& world_from_camera,
                                                  const Ellipse& observed, const ConicOptions& options = {});

}  // namespace uniquadric
