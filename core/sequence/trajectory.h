#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/geometry/pose.h"

namespace uniquadric {

struct StampedPose {
  std::int64_t stamp_ns = 0;
  Pose pose;  ///< world_from_camera or world_from_object
};
/// Poses in strictly increasing order of their stamps.
using Trajectory = std::vector<StampedPose>;

/// Of a coordinate: farther out than any place near the Earth in any datum, and still its squares add up to a
/// number.
inline constexpr double kMostCoordinate_m = 1e9;

/// Decimal seconds to integer nanoseconds without passing through a double; further digits are rounded.
/// Throws std::invalid_argument for anything else than an optionally signed number within kMostStamp_ns.
std::int64_t parse_stamp_ns(std::string_view seconds);
/// Seconds with nine decimals.
std::string format_stamp(std::int64_t stamp_ns);

/// The poses by their stamps.
std::map<std::int64_t, Pose> by_stamp(const Trajectory& trajectory);

/// Reads TUM text: `timestamp tx ty tz qx qy qz qw`, comments after #. Throws InputError with the line for a
/// malformed or non-finite number, a coordinate beyond kMostCoordinate_m, a stamp that decreases, or a
/// quaternion whose norm is off 1 by more than 1e-3 (closer ones are normalised; within 1e-12 they are kept
/// as they are, bit for bit). Of poses with equal stamps the first is kept; one warning counts the others.
Trajectory read_tum(const std::filesystem::path& path);
/// Writes TUM text with as many digits as reading back the same doubles needs.
void write_tum(const std::filesystem::path& path, const Trajectory& trajectory);

}  // namespace uniquadric
