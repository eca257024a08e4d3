#pragma once

#include <Eigen/Core>
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

}  // namespace uniquadric
