#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "evaluation/trajectory/trajectory_error.h"

namespace uniquadric {

/// Mean errors of parts of the path of one length.
struct KittiErrors {
  double translation_percent = 0;    ///< t_rel: error of the motion over the part, of its length
  double rotation_deg_per_100m = 0;  ///< r_rel
  std::size_t parts = 0;
};
struct KittiLength {
  double length_m = 0;
  KittiErrors errors;
};
struct KittiOdometry {
  KittiErrors mean;                  ///< over the parts of all lengths
  std::vector<KittiLength> lengths;  ///< that have parts
};

/// Errors of the KITTI odometry benchmark (its development kit): parts of 100, 200, ... 800 m of the
/// reference's path, started at every tenth pair, that end with the first pair past the length. Nothing where
/// the path is too short for one.
std::optional<KittiOdometry> kitti_odometry(const PosePairs& poses);

}  // namespace uniquadric
