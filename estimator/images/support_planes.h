#pragma once

#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "core/base/random.h"

namespace uniquadric {

/// A plane normal . p + offset_m = 0, |normal| = 1.
struct Plane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double offset_m = 0;
  double spread =
      0;  ///< of its points' distance, 1.48 medians, per metre of depth: as a sensor's noise grows
  double distance(const Eigen::Vector3d& p) const { return std::abs(normal.dot(p) + offset_m); }
};

/// Whether a point (camera frame) is no further off a plane than its points are: four spreads, `most_m` at
/// most.
bool lies_on(const Plane& plane, const Eigen::Vector3d& point, double most_m);

/// Planes of a cloud in a camera's frame, the largest first, by RANSAC and a least-squares fit to the
/// inliers: each has at least `share` of the points within `threshold_m`; at most `most` of them.
std::vector<Plane> find_planes(std::vector<Eigen::Vector3d> points, double threshold_m, double share,
                               int most, RandomStream& random);

}  // namespace uniquadric
