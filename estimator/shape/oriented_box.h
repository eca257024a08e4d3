#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/geometry/ellipsoid.h"

namespace uniquadric {

/// A box in the frame of the points it was fitted to: center [m], axes (columns, right-handed) and half
/// extents along them [m].
struct OrientedBox {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  Eigen::Vector3d half_extents_m = Eigen::Vector3d::Zero();
};

/// The ellipsoid inscribed in a box: its centre and axes, the half extents as semi-axes.
Ellipsoid inscribed_ellipsoid(const OrientedBox& box);

/// The same box with its axes renamed by one of the 24 box rotations.
OrientedBox relabel_axes(const OrientedBox& box, const Eigen::Matrix3d& P);

/// Distance of a point to the surface of a box, from outside or from inside [m] (Eq. 12, our reading; the
/// paper prints
/// |(p - c) . axis - axis|, which is zero at a corner alone).
double distance_to_surface(const OrientedBox& box, const Eigen::Vector3d& point);

/// Eq. 12 as printed: with q the point in the box's axes, |q - a|, the distance to the corner +a [m].
double distance_to_corner(const OrientedBox& box, const Eigen::Vector3d& point);

/// The tight box of points (3 x n, metres) with given axes.
OrientedBox box_along(const Eigen::Matrix3d& axes, const Eigen::Matrix3Xd& points);

/// The tight box along the principal axes of the points' covariance; nothing for fewer than 4 points.
std::optional<OrientedBox> fit_pca_box(const Eigen::Matrix3Xd& points);

/// A box of least volume, locally: from the principal axes and from planes through triples of points, the box
/// is turned about one of its axes after the other, each time to be flush with the best edge of the convex
/// hull of the points projected along that axis (rotating calipers), until the volume no longer falls.
/// Nothing for fewer than 4 points. Source: the flush-edge property of O'Rourke, "Finding minimal enclosing
/// boxes", 1985.
std::optional<OrientedBox> fit_minimum_volume_box(const Eigen::Matrix3Xd& points);

/// The same search for the tight box with the least mean distance of the points to its surface. A depth
/// camera sees two or three faces; the hull of two is a prism over a right triangle, which boxes along the
/// hypotenuse enclose with the same volume as the true one, while only the true one has the points on its
/// surface.
std::optional<OrientedBox> fit_surface_box(const Eigen::Matrix3Xd& points);

/// The same, the smaller of boxes whose surface fits alike: a single face, as of a plate seen from above,
/// says nothing of the turn about its normal, only its rim does.
std::optional<OrientedBox> fit_tight_surface_box(const Eigen::Matrix3Xd& points);

}  // namespace uniquadric
