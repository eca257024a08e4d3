#include "core/import/fields.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "core/base/config.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/sequence/trajectory.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr double kRotationTolerance = 1e-3;  // of R^T R: files have 7 digits or more
constexpr double kUnitTolerance = 1e-3;      // of a quaternion's norm, as in trajectories
constexpr std::int64_t kMostSeconds =
    4'000'000'000;  // the year 2096; nanoseconds of two of them fit into 64 bits
constexpr std::int64_t kSecond_ns = 1'000'000'000;

// Why these are no rows of a rigid transform, empty where they are.
std::string pose_of(const std::vector<double>& v, Pose& pose) {
  if (v.size() != 9 && v.size() != 12 && v.size() != 16)
    return fmt::format("expected the 16 numbers of a 4x4 matrix, found {}", v.size());
  const std::size_t columns = v.size() == 9 ? 3 : 4;
  Eigen::Matrix<double, 3, 4> matrix = Eigen::Matrix<double, 3, 4>::Zero();
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < columns; ++j)
      matrix(static_cast<int>(i), static_cast<int>(j)) = v[i * columns + j];
  if (v.size() == 16 && !(v[12] == 0 && v[13] == 0 && v[14] == 0 && v[15] == 1))
    return "the last row of the matrix is not 0 0 0 1";
  const auto found = rigid_pose(matrix);
  if (!found) return "the matrix is no rotation";
  pose = *found;
  return "";
}

}  // namespace

std::vector<double> read_numbers(const fs::path& path, int line, const Fields& fields, std::size_t begin) {
  std::vector<double> values;
  for (std::size_t i = begin; i < fields.size(); ++i) {
    const auto value = parse_double(fields[i]);
    if (!value) throw InputError(path, line, fmt::format("'{}' is not a finite number", fields[i]));
    values.push_back(*value);
  }
  return values;
}

std::int64_t read_count(const fs::path& path, int line, std::string_view field, const char* what,
                        std::int64_t end) {
  const auto value = parse_integer(field);
  if (!value || *value < 0 || *value >= end)
    throw InputError(path, line,
                     fmt::format("{} '{}' is no whole number from 0 to {}", what, field, end - 1));
  return *value;
}

std::int64_t read_seconds_and_ns(const fs::path& path, int line, std::string_view seconds,
                                 std::string_view nanoseconds) {
  return read_count(path, line, seconds, "time in seconds", kMostSeconds) * kSecond_ns +
         read_count(path, line, nanoseconds, "nanoseconds", kSecond_ns);
}

void for_each_row(const fs::path& path, std::size_t columns,
                  const std::function<void(int, const Fields&)>& visit) {
  bool is_first = true;
  for_each_line(
      path,
      [&](int line, const Fields& fields) {
        if (std::exchange(is_first, false) && !parse_double(fields[0])) return;
        if (fields.size() != columns)
          throw InputError(path, line, fmt::format("expected {} columns, found {}", columns, fields.size()));
        visit(line, fields);
      },
      ',');
}

std::vector<std::int64_t> read_times(const fs::path& path) {
  std::vector<std::int64_t> stamps_ns;
  for_each_line(path, [&](int line, const Fields& fields) {
    if (fields.size() != 1) throw InputError(path, line, "expected one time in seconds");
    try {
      stamps_ns.push_back(parse_stamp_ns(fields[0]));
    } catch (const std::invalid_argument& error) {
      throw InputError(path, line, error.what());
    }
    if (stamps_ns.size() > 1) require_later(path, line, *(stamps_ns.end() - 2), stamps_ns.back());
  });
  return stamps_ns;
}

void require_later(const fs::path& path, int line, std::optional<std::int64_t> before_ns,
                   std::int64_t stamp_ns) {
  if (before_ns && stamp_ns <= *before_ns)
    throw InputError(
        path, line,
        fmt::format("timestamp {} does not come after {}", format_stamp(stamp_ns), format_stamp(*before_ns)));
}

std::vector<ImuSample> read_imu_rows(const fs::path& path, std::size_t columns,
                                     const std::function<std::int64_t(int, const Fields&)>& read_stamp) {
  std::vector<ImuSample> samples;
  for_each_row(path, columns, [&](int line, const Fields& fields) {
    const std::int64_t stamp_ns = read_stamp(line, fields);
    require_later(path, line, samples, stamp_ns);
    const auto v = read_numbers(path, line, fields, columns - 6);
    samples.push_back({stamp_ns, {v[0], v[1], v[2]}, {v[3], v[4], v[5]}});
  });
  if (samples.empty()) throw InputError(path, "has no sample");
  return samples;
}

Eigen::Quaterniond read_unit(const fs::path& path, int line, const Eigen::Quaterniond& q) {
  if (!(std::abs(q.norm() - 1) <= kUnitTolerance))
    throw InputError(path, line, fmt::format("quaternion has norm {:.6g}, not 1", q.norm()));
  return q.normalized();
}

std::optional<Pose> rigid_pose(const Eigen::Matrix<double, 3, 4>& matrix) {
  const Eigen::Matrix3d rotation = matrix.leftCols<3>();
  const double off = (rotation.transpose() * rotation - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(off < kRotationTolerance) || rotation.determinant() < 0) return std::nullopt;
  return Pose{Eigen::Quaterniond(rotation).normalized(), matrix.col(3)};
}

Pose read_pose_rows(const fs::path& path, int line, const std::vector<double>& values) {
  Pose pose;
  if (const std::string what = pose_of(values, pose); !what.empty()) throw InputError(path, line, what);
  return pose;
}

Pose read_pose_matrix(const ConfigNode& node) {
  std::vector<double> values;
  for (const ConfigNode& row : node.items()) {
    const auto numbers = row.is_sequence() ? row.as<std::vector<double>>() : std::vector{row.as<double>()};
    values.insert(values.end(), numbers.begin(), numbers.end());
  }
  Pose pose;
  if (const std::string what =
          values.size() == 16 ? pose_of(values, pose) : "expected the 16 numbers of a 4x4 matrix";
      !what.empty())
    node.fail(what);
  return pose;
}

}  // namespace uniquadric
