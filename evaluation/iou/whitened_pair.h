#pragma once

#include <Eigen/Core>

#include "core/geometry/ellipsoid.h"

namespace uniquadric {

/// Two ellipsoids seen from a frame in which the larger one is the unit ball about the origin and the other
/// one is axis-aligned. Volumes keep their ratios.
struct WhitenedPair {
  Eigen::Vector3d center;     ///< of the smaller ellipsoid
  Eigen::Vector3d semi_axes;  ///< of the smaller ellipsoid, in decreasing order
  bool identical = false;     ///< both are the same body, to rounding
  /// Volume of the smaller ellipsoid over that of the larger.
  double volume_ratio() const { return semi_axes.prod(); }
};

/// The same result for both orders of the arguments. Only the difference of the centres enters, so that
/// distance from the world's origin costs no digits. Asserts finite poses and positive semi-axes.
WhitenedPair whiten(const Ellipsoid& a, const Ellipsoid& b);

}  // namespace uniquadric
