#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "estimator/shape/accumulated_cloud.h"

namespace uniquadric {

/// How far a body reaches along a direction of its frame: direction . x <= position_m for all its points.
struct BodySide {
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();
  double position_m = 0;
  double sigma_m = 0;
  int views = 0;  ///< frames whose camera lies before the side
  /// Whether a camera lay before the side. If none did, the points end where they turn out of sight, and
  /// position_m is no more than the least that the body reaches.
  bool seen = false;
};

struct AccumulatedBoxOptions {
  double min_view_sine = 0.25;    // ours: sine of the angle at which a side must be looked upon, 14 degrees
  double min_cloud_weight = 200;  // ours: points; fewer say nothing about where a body ends
  double pose_sigma_m = 0.003;    // ours: of one view; falls with the root of their number
  double model_sigma_m =
      0.003;  // ours: largest bias measured (docs/shape.md): edges that are no face and no ball
};

/// The side of the accumulated cloud along a direction (unit). Nothing for too few points.
/// It constrains a shape as a tangent plane of the body's frame: normal = direction, offset = -position_m.
std::optional<BodySide> accumulated_side(const AccumulatedCloud& cloud, const Eigen::Vector3d& direction,
                                         const AccumulatedBoxOptions& options = {});

/// The box of an accumulated cloud along given axes.
struct AccumulatedBox {
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< columns: body_from_shape's rotation
  std::array<BodySide, 6> sides;                       ///< +x, -x, +y, -y, +z, -z of the axes

  /// Both sides of the axis are seen.
  bool measured(int axis) const { return sides[2 * axis].seen && sides[2 * axis + 1].seen; }
  /// Half the distance of an axis's two sides and its standard deviation [m].
  double half_extent_m(int axis) const;
  double half_extent_sigma_m(int axis) const;
  /// Centre in the body's frame [m]; of an axis with an unseen side, that of what was seen.
  Eigen::Vector3d center() const;
};
std::optional<AccumulatedBox> accumulated_box(const AccumulatedCloud& cloud, const Eigen::Matrix3d& axes,
                                              const AccumulatedBoxOptions& options = {});

}  // namespace uniquadric
