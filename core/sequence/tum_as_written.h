#pragma once

#include <filesystem>
#include <vector>

#include "core/sequence/trajectory.h"

namespace uniquadric {

/// The poses of a TUM file in its order: their stamps may repeat or decrease.
struct WrittenPoses {
  std::vector<StampedPose> poses;
  std::vector<double> stamps_s;  ///< as the doubles nearest to the file's digits
};

/// As read_tum, whatever the stamps' order.
WrittenPoses read_tum_as_written(const std::filesystem::path& path);

}  // namespace uniquadric
