#pragma once

#include <cstdint>
#include <string>

#include "core/geometry/pose.h"

namespace uniquadric {

/// Stamp and frame of a message: the `Header` of ROS.
struct BagHeader {
  std::int64_t stamp_ns = 0;  ///< more than 0: ROS takes 0 for "no time"
  std::string frame_id;
};

/// A transform parent_from_child of the static tree.
struct BagTransform {
  std::string parent, child;
  Pose parent_from_child;
};

}  // namespace uniquadric
