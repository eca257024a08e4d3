#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string_view>
#include <vector>

#include "core/geometry/pose.h"
#include "core/sequence/imu.h"

namespace uniquadric {

class ConfigNode;

// What the readers of recordings' text files share. All throw InputError with file and line.

using Fields = std::vector<std::string_view>;

/// The fields from `begin` on, each a finite number.
std::vector<double> read_numbers(const std::filesystem::path& path, int line, const Fields& fields,
                                 std::size_t begin = 0);

/// A whole number from 0 to `end` - 1; `what` names it in the message.
std::int64_t read_count(const std::filesystem::path& path, int line, std::string_view field, const char* what,
                        std::int64_t end);

/// Whole seconds and the nanoseconds of the second.
std::int64_t read_seconds_and_ns(const std::filesystem::path& path, int line, std::string_view seconds,
                                 std::string_view nanoseconds);

/// Rows of a CSV file with that many columns; a first row that begins with no number is its header.
void for_each_row(const std::filesystem::path& path, std::size_t columns,
                  const std::function<void(int line, const Fields&)>& visit);

/// Times in seconds, one a line, increasing.
std::vector<std::int64_t> read_times(const std::filesystem::path& path);

/// A stamp that comes after the one before it, `before_ns` (nothing: the first).
void require_later(const std::filesystem::path& path, int line, std::optional<std::int64_t> before_ns,
                   std::int64_t stamp_ns);
/// A stamp that comes after that of the last of a list.
template <typename Stamped>
void require_later(const std::filesystem::path& path, int line, const std::vector<Stamped>& before,
                   std::int64_t stamp_ns) {
  if (!before.empty()) require_later(path, line, before.back().stamp_ns, stamp_ns);
}

/// An IMU's rows with that many columns, angular velocity [rad/s] and specific force [m/s^2] being the last
/// six; at least one, later and later by `read_stamp`.
std::vector<ImuSample> read_imu_rows(const std::filesystem::path& path, std::size_t columns,
                                     const std::function<std::int64_t(int line, const Fields&)>& read_stamp);

/// The rotation of a quaternion whose norm is within 1e-3 of 1.
Eigen::Quaterniond read_unit(const std::filesystem::path& path, int line, const Eigen::Quaterniond& q);

/// A rigid transform of its matrix [R t]; nothing where R is no rotation to 1e-3.
std::optional<Pose> rigid_pose(const Eigen::Matrix<double, 3, 4>& matrix);
/// The same of numbers row by row: 9 (no translation), 12, or 16 with the last row 0 0 0 1.
Pose read_pose_rows(const std::filesystem::path& path, int line, const std::vector<double>& values);
/// The same of a YAML list: 16 numbers, or 4 rows of 4.
Pose read_pose_matrix(const ConfigNode& node);

}  // namespace uniquadric
