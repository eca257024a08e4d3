#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string_view>
#include <vector>

namespace uniquadric {

/// `count` low-discrepancy points in the unit cube, shifted at random: by the stream of that seed and name,
/// each replicate by another shift.
std::vector<Eigen::Vector3d> shifted_sequence(int count, std::uint64_t seed, std::string_view name,
                                              int replicate);

}  // namespace uniquadric
