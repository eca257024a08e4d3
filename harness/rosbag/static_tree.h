#pragma once

#include <optional>
#include <string>
#include <vector>

#include "harness/rosbag/bag_message.h"

namespace uniquadric {

/// target_from_source by the static transforms, whatever way the tree leads; the identity for one frame.
/// Nothing where no way leads from one to the other.
std::optional<Pose> static_transform(const std::vector<BagTransform>& transforms, const std::string& target,
                                     const std::string& source);

}  // namespace uniquadric
