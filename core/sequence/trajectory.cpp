#include "core/sequence/trajectory.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/text.h"
#include "core/base/warning.h"
#include "core/sequence/stamps.h"
#include "core/sequence/tum_as_written.h"

namespace uniquadric {
namespace {

constexpr double kQuaternionTolerance = 1e-3;       // SPEC: further off is an error
constexpr double kQuaternionKeepTolerance = 1e-12;  // rounding of a unit quaternion's own digits
constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;
constexpr double kMostStamp_s = static_cast<double>(kMostStamp_ns) / kNanosecondsPerSecond;

double parse_number(const std::filesystem::path& path, int line, std::string_view field) {
  const auto value = parse_double(field);
  if (!value) throw InputError(path, line, fmt::format("'{}' is not a finite number", field));
  return *value;
}

StampedPose parse_line(const std::filesystem::path& path, int line,
                       const std::vector<std::string_view>& fields) {
  if (fields.size() != 8)
    throw InputError(
        path, line,
        fmt::format("expected 8 numbers (timestamp tx ty tz qx qy qz qw), found {}", fields.size()));
  StampedPose result;
  try {
    result.stamp_ns = parse_stamp_ns(fields[0]);
  } catch (const std::invalid_argument&) {
    throw InputError(path, line, fmt::format("'{}' is not a timestamp in seconds", fields[0]));
  }
  std::array<double, 7> v{};
  for (int i = 0; i < 7; ++i) v[i] = parse_number(path, line, fields[i + 1]);
  for (int i = 0; i < 3; ++i)
    if (std::abs(v[i]) > kMostCoordinate_m)
      throw InputError(
          path, line,
          fmt::format("'{}' is further than {} m from the origin", fields[i + 1], kMostCoordinate_m));
  result.pose.translation = {v[0], v[1], v[2]};
  result.pose.rotation = Eigen::Quaterniond(v[6], v[3], v[4], v[5]);
  const double off = std::abs(result.pose.rotation.norm() - 1);
  if (!(off <= kQuaternionTolerance))
    throw InputError(path, line, fmt::format("quaternion has norm {}, not 1", result.pose.rotation.norm()));
  if (off > kQuaternionKeepTolerance) result.pose.rotation.normalize();
  return result;
}

}  // namespace

std::int64_t parse_stamp_ns(std::string_view text) {
  const auto fail = [&] { throw std::invalid_argument("not a timestamp: " + std::string(text)); };
  std::string_view rest = text;
  const bool negative = rest.starts_with('-');
  if (negative || rest.starts_with('+')) rest.remove_prefix(1);
  // 1.3e9: rare, and good to a double's precision. (find_first_of is a call of memchr for each character.)
  if (std::ranges::any_of(rest, [](char c) { return c == 'e' || c == 'E'; })) {
    const auto value = parse_double(text);
    if (!value || std::abs(*value) > kMostStamp_s) fail();
    return std::llround(*value * 1e9);
  }
  std::int64_t ns = 0;
  int digits = 0, decimals = -1;
  bool round_up = false;
  for (const char c : rest) {
    if (c == '.' && decimals < 0) {
      decimals = 0;
      continue;
    }
    if (c < '0' || c > '9') fail();
    ++digits;
    if (decimals == 9) {
      round_up = c >= '5';
      ++decimals;
    }
    if (decimals > 9) continue;
    if (ns > (std::numeric_limits<std::int64_t>::max() - 9) / 10) fail();
    ns = ns * 10 + (c - '0');
    if (decimals >= 0) ++decimals;
  }
  if (digits == 0) fail();
  for (int i = std::max(decimals, 0); i < 9; ++i)
    if (__builtin_mul_overflow(ns, 10, &ns)) fail();
  if (ns > kMostStamp_ns) fail();
  ns += round_up ? 1 : 0;
  return negative ? -ns : ns;
}

std::optional<std::int64_t> parse_stamp_of_ns(std::string_view text) {
  const auto ns = parse_integer(text);
  return ns && *ns >= -kMostStamp_ns && *ns <= kMostStamp_ns ? std::optional<std::int64_t>(*ns)
                                                             : std::nullopt;
}

std::string format_stamp(std::int64_t stamp_ns) {
  const bool negative = stamp_ns < 0;
  const std::uint64_t size =
      negative ? -static_cast<std::uint64_t>(stamp_ns) : static_cast<std::uint64_t>(stamp_ns);
  return fmt::format("{}{}.{:09d}", negative ? "-" : "", size / kNanosecondsPerSecond,
                     size % kNanosecondsPerSecond);
}

Trajectory read_tum(const std::filesystem::path& path) {
  Trajectory trajectory;
  std::size_t repeated = 0, digits_before = 0, digits = 0;  // of the last number of a line
  for_each_line(path, [&](int line, const std::vector<std::string_view>& fields) {
    const StampedPose pose = parse_line(path, line, fields);
    if (!trajectory.empty() && pose.stamp_ns < trajectory.back().stamp_ns)
      throw InputError(
          path, line,
          fmt::format("timestamp {} comes before {}", fields[0], format_stamp(trajectory.back().stamp_ns)));
    if (!trajectory.empty() && pose.stamp_ns == trajectory.back().stamp_ns)
      ++repeated;
    else
      trajectory.push_back(pose);
    digits_before = std::exchange(digits, fields.back().size());
  });
  if (digits < digits_before && !read_text(path).ends_with('\n'))
    warn(fmt::format(
        "{}: the last line has no end, and its last number is shorter than the one before: the file may "
        "be cut",
        path.string()));
  if (repeated > 0)
    warn(fmt::format("{}: {} of {} poses repeat the timestamp before them: the first of each is kept",
                     path.string(), repeated, trajectory.size() + repeated));
  return trajectory;
}

WrittenPoses read_tum_as_written(const std::filesystem::path& path) {
  WrittenPoses written;
  for_each_line(path, [&](int line, const std::vector<std::string_view>& fields) {
    written.poses.push_back(parse_line(path, line, fields));
    written.stamps_s.push_back(parse_number(path, line, fields[0]));
  });
  return written;
}

void write_tum(const std::filesystem::path& path, const Trajectory& trajectory) {
  std::string text = "# timestamp tx ty tz qx qy qz qw\n";
  for (const auto& [stamp_ns, pose] : trajectory) {
    const auto& t = pose.translation;
    const auto& q = pose.rotation;
    text += fmt::format("{} {} {} {} {} {} {} {}\n", format_stamp(stamp_ns), t.x(), t.y(), t.z(), q.x(),
                        q.y(), q.z(), q.w());
  }
  write_text(path, text);
}

std::map<std::int64_t, Pose> by_stamp(const Trajectory& trajectory) {
  std::map<std::int64_t, Pose> poses;
  for (const auto& [stamp_ns, pose] : trajectory) poses.emplace(stamp_ns, pose);
  return poses;
}

}  // namespace uniquadric
