#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "estimator/shape/reach.h"
#include "estimator/window/long_window.h"

namespace uniquadric {

/// What says where a body's sides are.
struct SideEvidence {
  const std::vector<PointView>& views;
  const Eigen::Matrix3Xd& surface_points;  ///< (3 x n), body frame [m]
  double radius_m;                         ///< of the body's first sphere
  const std::vector<ContactSide>& contacts;
};

/// Whether clearly fewer of the surface's points lie off the sides of `other`'s box, as far as views show it,
/// than off those of `best`. No family of shapes holds every body: of two that fit alike, the one whose sides
/// are the body's has its axes.
bool has_closer_sides(const Shape& other, const Shape& best, const SideEvidence& evidence);

/// The box about a body. A body that is not convex, as an angle, has sides that no shape of the family
/// follows: the best one is about its hull. The box has other axes if the surface's points fill a clearly
/// smaller one along them, no more of these lie off its sides, and not clearly fewer lie off the shape's own
/// surface, as an ellipsoid's. Its ends are what views show. Otherwise nothing.
/// `before`: the box until now, whose axes are kept while they hold. `looks`: whether to look for others
/// (fit_tight_surface_box), named as they are nearest to those of before.
std::optional<Shape> box_about(const Shape& shape, const std::optional<Shape>& before, bool looks,
                               const SideEvidence& evidence);

}  // namespace uniquadric
