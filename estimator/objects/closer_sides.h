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

/// The box about a body. One that is not convex, as an angle, has sides that no shape of the family follows,
/// and the family's best is about its hull. Where the surface's points fill a box along other axes that is
/// clearly smaller, and no more of them lie off its sides, the body has these axes, but where clearly fewer
/// lie off the shape's own surface, as an ellipsoid's. Its ends are what views show. `axes` (columns, body's
/// frame): found before, kept while they hold. `looks`: whether to look for others (fit_tight_surface_box),
/// named as they are nearest to those of before. Otherwise `shape`.
Shape box_about(const Shape& shape, std::optional<Eigen::Matrix3d>& axes, bool looks,
                const SideEvidence& evidence);

}  // namespace uniquadric
