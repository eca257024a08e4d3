#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "estimator/observation/perception.h"

namespace uniquadric {

/// What one scan shows of a body, along the ground of a world whose z is up [m].
struct UprightSight {
  std::int64_t frame = 0, stamp_ns = 0;
  Eigen::Matrix2Xd points;
  std::vector<bool> cut;  ///< as in BodyObservation
  Eigen::Vector2d sensor = Eigen::Vector2d::Zero();
  double bottom_m = 0;  ///< z of the ground under it
  double height_m = 0, height_sigma_m = 0;
  double beam_gap_m = 0, row_gap_m = 0;  ///< as in BodyObservation
};

/// A body with the ground under it (`contact`), and points.
UprightSight upright_sight(const FrameInfo& frame, const BodyObservation& body);

/// As if it ended where the last beam met it, and upwards half-way to the next row.
UprightSight without_gaps(UprightSight sight);

/// Where a body ends in a direction, by the points that are furthest there.
struct BoxEnd {
  Eigen::Vector2d direction = Eigen::Vector2d::UnitX();  ///< outward
  double position_m = 0;                                 ///< direction . p of the end
  double sigma_m = 0;
  double beyond_m = 0;    ///< that the body may go on by, as the next beam missed it
  bool is_bound = false;  ///< the body may go on beyond, however far
};

/// The ends of a body at its back, front, right and left, whose length has this yaw. A side that faces the
/// sensor is seen; one that faces away is seen where another one leads up to it. How far apart the last
/// points are, towards an end, tells how well it is known.
std::array<BoxEnd, 4> box_ends(const UprightSight& sight, double yaw_rad);

struct SeenYaw {
  double yaw_rad = 0, sigma_rad = 0;
};

/// The yaw, within `reach_rad` of the expected one, in which the points lie nearest to the sides of their box
/// that face the sensor (after Zhang et al., "Efficient L-shape fitting", IV 2017: their closeness, over
/// sides in view alone). Nothing where they do not say.
std::optional<SeenYaw> seen_yaw(const UprightSight& sight, double expected_rad, double reach_rad);

}  // namespace uniquadric
