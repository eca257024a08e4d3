#include "estimator/ego/lidar_sweep.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <unordered_map>

namespace uniquadric {
namespace {

InertialReading reading_at(const std::vector<ImuSample>& samples, std::int64_t stamp_ns) {
  const auto after = std::lower_bound(samples.begin(), samples.end(), stamp_ns,
                                      [](const ImuSample& s, std::int64_t t) { return s.stamp_ns < t; });
  if (after == samples.begin() || after == samples.end()) {
    const ImuSample& held = after == samples.end() ? samples.back() : *after;
    return {held.angular_velocity_radps, held.specific_force_mps2};
  }
  const ImuSample &a = *std::prev(after), &b = *after;
  const double u = static_cast<double>(stamp_ns - a.stamp_ns) / static_cast<double>(b.stamp_ns - a.stamp_ns);
  return {a.angular_velocity_radps + u * (b.angular_velocity_radps - a.angular_velocity_radps),
          a.specific_force_mps2 + u * (b.specific_force_mps2 - a.specific_force_mps2)};
}

// Coprime to n, and so far from simple fractions of it that successive points lie far apart.
std::size_t stride_of(std::size_t n) {
  constexpr double kGolden = 0.6180339887498949;
  auto stride = static_cast<std::size_t>(kGolden * static_cast<double>(n));
  while (stride > 1 && std::gcd(stride, n) != 1) --stride;
  return std::max<std::size_t>(stride, 1);
}

}  // namespace

std::vector<TimedPoint> clean_points(std::int64_t start_ns, const std::vector<LidarPoint>& points,
                                     const SweepOptions& options) {
  std::vector<TimedPoint> result;
  result.reserve(points.size());
  const double least = options.min_range_m * options.min_range_m;
  const double most = options.max_range_m * options.max_range_m;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const LidarPoint& p = points[i];
    const Eigen::Vector3d place(p.x, p.y, p.z);
    const double square = place.squaredNorm();
    if (!(square >= least && square <= most)) continue;  // nor what is no number
    if (p.offset_ns > options.max_scan_s * 1e9)
      throw std::invalid_argument(
          fmt::format("point {}: {} s after the scan's start", i, static_cast<double>(p.offset_ns) * 1e-9));
    result.push_back({start_ns + p.offset_ns, place.cast<float>()});
  }
  std::stable_sort(result.begin(), result.end(),
                   [](const TimedPoint& a, const TimedPoint& b) { return a.stamp_ns < b.stamp_ns; });
  return result;
}

std::vector<ReadingPiece> readings_between(const std::vector<ImuSample>& samples, std::int64_t from_ns,
                                           std::int64_t to_ns) {
  if (samples.empty()) return {{to_ns, {}}};
  std::vector<ReadingPiece> pieces;
  auto next = std::upper_bound(samples.begin(), samples.end(), from_ns,
                               [](std::int64_t t, const ImuSample& s) { return t < s.stamp_ns; });
  for (std::int64_t t = from_ns; t < to_ns;) {
    const std::int64_t end = next == samples.end() ? to_ns : std::min(to_ns, next->stamp_ns);
    pieces.push_back({end, reading_at(samples, t + (end - t) / 2)});
    if (next != samples.end()) ++next;
    t = end;
  }
  return pieces;
}

SweepPath::SweepPath(const LidarState& start, const std::vector<ReadingPiece>& pieces) : end_(start) {
  for (const auto& [end_ns, reading] : pieces) {
    pieces_.push_back({end_, reading});
    end_ = propagated(end_, reading, end_ns);
  }
}

SweepPoint SweepPath::place(std::int64_t stamp_ns, const Eigen::Vector3d& body) const {
  const auto after = std::upper_bound(pieces_.begin(), pieces_.end(), stamp_ns,
                                      [](std::int64_t t, const Piece& p) { return t < p.start.stamp_ns; });
  if (pieces_.empty()) return {body};
  const Piece& piece = after == pieces_.begin() ? *after : *std::prev(after);
  stamp_ns = std::clamp(stamp_ns, pieces_.front().start.stamp_ns, end_.stamp_ns);
  const LidarState then = propagated(piece.start, piece.reading, stamp_ns);
  SweepPoint point;
  point.body = body;
  point.age_s = static_cast<double>(end_.stamp_ns - stamp_ns) * 1e-9;
  point.end_from_then =
      (end_.world_from_body.rotation.conjugate() * then.world_from_body.rotation).toRotationMatrix();
  point.bend_m =
      then.world_from_body.translation - end_.world_from_body.translation + point.age_s * end_.velocity_mps;
  return point;
}

VoxelChoice choose_points(const std::vector<TimedPoint>& points, double voxel_m) {
  VoxelChoice choice;
  choice.voxel_of.resize(points.size());
  std::unordered_map<std::uint64_t, int> voxels;
  voxels.reserve(points.size() / 2);
  const std::size_t n = points.size(), stride = stride_of(n);
  for (std::size_t i = 0, k = 0; k < n; ++k, i = (i + stride) % n) {
    std::uint64_t key = 0;  // 21 bits an axis: 2 million voxels either way
    for (int axis = 0; axis < 3; ++axis) {
      const auto cell = static_cast<std::int64_t>(std::floor(points[i].lidar[axis] / voxel_m));
      key = key << 21 | (static_cast<std::uint64_t>(cell) & 0x1FFFFF);
    }
    const auto [found, is_new] = voxels.try_emplace(key, static_cast<int>(choice.point_of.size()));
    if (is_new) choice.point_of.push_back(static_cast<int>(i));
    choice.voxel_of[i] = found->second;
  }
  return choice;
}

}  // namespace uniquadric
