#include "estimator/plausibility/pose_lookup.h"

#include <algorithm>
#include <cstdlib>

namespace uniquadric {
namespace {

constexpr std::int64_t kSame_ns = 1'000'000, kWidest_ns = 500'000'000;

}  // namespace

std::optional<Pose> pose_near(const Trajectory& trajectory, std::int64_t stamp_ns) {
  const auto after = std::lower_bound(trajectory.begin(), trajectory.end(), stamp_ns,
                                      [](const StampedPose& p, std::int64_t ns) { return p.stamp_ns < ns; });
  if (after != trajectory.end() && after->stamp_ns - stamp_ns <= kSame_ns) return after->pose;
  if (after == trajectory.begin()) return std::nullopt;
  const auto before = std::prev(after);
  if (stamp_ns - before->stamp_ns <= kSame_ns) return before->pose;
  if (after == trajectory.end() || after->stamp_ns - before->stamp_ns > kWidest_ns) return std::nullopt;
  return interpolate(before->pose, after->pose,
                     static_cast<double>(stamp_ns - before->stamp_ns) /
                         static_cast<double>(after->stamp_ns - before->stamp_ns));
}

}  // namespace uniquadric
