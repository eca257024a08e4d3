#include "evaluation/iou/monte_carlo.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "core/base/random.h"
#include "evaluation/iou/whitened_pair.h"

namespace uniquadric {
namespace {

// Additive recurrence by the root of x^4 = x + 1, the three-dimensional golden ratio (M. Roberts, "The
// unreasonable effectiveness of quasirandom sequences", 2018).
constexpr double kGolden3 = 1.2207440846057596;

Eigen::Vector3d ball_point(const Eigen::Vector3d& unit_cube) {
  const double radius = std::cbrt(unit_cube.x());
  const double z = 2 * unit_cube.y() - 1;
  const double angle = 2 * std::numbers::pi * unit_cube.z();
  const double ring = std::sqrt((1 - z) * (1 + z));
  return radius * Eigen::Vector3d(ring * std::cos(angle), ring * std::sin(angle), z);
}

// d IoU / d share, with IoU = share v / (1 + v - share v) and v the volume ratio.
double iou_slope(double share, double ratio) {
  const double all = 1 + ratio - share * ratio;
  return ratio * (1 + ratio) / (all * all);
}

}  // namespace

BallSamples::BallSamples(int samples, std::uint64_t seed) {
  assert(samples > 0);
  const int each = (samples + kReplicates - 1) / kReplicates;
  const Eigen::Array3d step(1 / kGolden3, 1 / (kGolden3 * kGolden3), 1 / (kGolden3 * kGolden3 * kGolden3));
  points_.reserve(static_cast<std::size_t>(each) * kReplicates);
  for (int replicate = 0; replicate < kReplicates; ++replicate) {
    RandomStream random(seed, "iou3d", static_cast<std::uint64_t>(replicate));
    const double x = random.uniform(), y = random.uniform(), z = random.uniform();
    for (int i = 0; i < each; ++i) {
      const Eigen::Array3d u = Eigen::Array3d(x, y, z) + i * step;
      points_.push_back(ball_point((u - u.floor()).matrix()));
    }
  }
}

MonteCarloIou ellipsoid_iou_monte_carlo(const Ellipsoid& a, const Ellipsoid& b, const BallSamples& samples) {
  const WhitenedPair pair = whiten(a, b);
  if (pair.identical) return {1, 0};
  const double ratio = pair.volume_ratio();
  const double each = samples.per_replicate();
  double sum = 0, squares = 0;
  auto point = samples.points().begin();
  for (int replicate = 0; replicate < BallSamples::kReplicates; ++replicate) {
    int inside = 0;
    for (int i = 0; i < samples.per_replicate(); ++i, ++point)
      inside += (pair.center + pair.semi_axes.cwiseProduct(*point)).squaredNorm() <= 1 ? 1 : 0;
    const double share = inside / each;
    sum += share;
    squares += share * share;
  }
  constexpr double n = BallSamples::kReplicates;
  const double share = sum / n;
  const double variance = std::max(0.0, squares / n - share * share) / (n - 1);
  // No replicate may have seen a common part that is smaller than a sample: the error is never below one
  // sample.
  const double error = std::max(std::sqrt(variance), 1 / (n * each));
  return {share * ratio / (1 + ratio - share * ratio), error * iou_slope(share, ratio)};
}

}  // namespace uniquadric
