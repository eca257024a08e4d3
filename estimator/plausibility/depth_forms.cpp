#include "estimator/plausibility/depth_forms.h"

#include <fmt/format.h>

#include "core/base/quantile.h"
#include "estimator/observation/ideal_ray.h"

namespace uniquadric {
namespace {

constexpr std::size_t kLeastPairs = 6;
constexpr double kBetter = 0.6;     // of the residual as it is, median of the pairs
constexpr double kMostPairs = 0.8;  // of the pairs must agree
constexpr double kSigma = 0.004;    // of depth, relative: what points are off by anyway

// Median distance in depth and in space of the points from where the motion puts them, relative.
double residual(const Camera& camera, const FramePair& pair) {
  std::vector<double> off;
  for (const PointPair& p : pair.points) {
    if (!(p.depth_a_m > 0 && p.depth_b_m > 0)) continue;
    const Eigen::Vector3d moved = *pair.b_from_a * (p.depth_a_m * ideal_ray(camera, p.a));
    off.push_back((moved - p.depth_b_m * ideal_ray(camera, p.b)).norm() / p.depth_b_m);
  }
  return off.empty() ? 0 : quantile(std::move(off), 0.5);
}

FramePair by_ray_length(const Camera& camera, FramePair pair) {
  for (PointPair& p : pair.points) {
    p.depth_a_m /= ideal_ray(camera, p.a).norm();
    p.depth_b_m /= ideal_ray(camera, p.b).norm();
  }
  fit_pair(camera, pair);
  return pair;
}

}  // namespace

std::vector<std::string> depth_form_suspicions(const Sequence& sequence,
                                               const std::vector<FramePair>& pairs) {
  std::vector<double> ratios;
  std::size_t better = 0;
  for (const FramePair& pair : pairs) {
    if (!pair.b_from_a) continue;
    const FramePair other = by_ray_length(sequence.camera, pair);
    if (!other.b_from_a) continue;
    const double now = residual(sequence.camera, pair), then = residual(sequence.camera, other);
    ratios.push_back(then / std::max(now, 1e-9));
    better += then < now && now > 0.25 * kSigma;
  }
  if (ratios.size() < kLeastPairs) return {};
  const double ratio = quantile(ratios, 0.5);
  if (ratio > kBetter || static_cast<double>(better) < kMostPairs * static_cast<double>(ratios.size()))
    return {};
  return {fmt::format(
      "{}: depth looks like the length of the ray in place of z: points move {:.1f} times as rigidly then",
      (sequence.folder / "depth.txt").string(), 1 / ratio)};
}

}  // namespace uniquadric
