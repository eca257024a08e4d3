#include "evaluation/iou/monte_carlo.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "evaluation/iou/count_inside_parts.h"
#include "evaluation/iou/shifted_sequence.h"
#include "evaluation/iou/whitened_pair.h"

namespace uniquadric {
namespace {

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
  for (Eigen::VectorXd& column : columns_) column.resize(Eigen::Index{each} * kReplicates);
  Eigen::Index n = 0;
  for (int replicate = 0; replicate < kReplicates; ++replicate)
    for (const Eigen::Vector3d& unit_cube : shifted_sequence(each, seed, "iou3d", replicate)) {
      const Eigen::Vector3d point = ball_point(unit_cube);
      for (int k = 0; k < 3; ++k) columns_[static_cast<std::size_t>(k)][n] = point[k];
      ++n;
    }
}

MonteCarloIou ellipsoid_iou_monte_carlo(const Ellipsoid& a, const Ellipsoid& b, const BallSamples& samples) {
  const WhitenedPair pair = whiten(a, b);
  if (pair.identical) return {1, 0};
  const double ratio = pair.volume_ratio();
  static const CountInside best = count_inside_avx2();
  const CountInside count = best ? best : count_inside_baseline;
  const int each = samples.per_replicate();
  double sum = 0, squares = 0;
  for (Eigen::Index begin = 0; begin < samples.size(); begin += each) {
    const double share = static_cast<double>(count(samples.x().data() + begin, samples.y().data() + begin,
                                                   samples.z().data() + begin, each, pair.center.data(),
                                                   pair.semi_axes.data())) /
                         each;
    sum += share;
    squares += share * share;
  }
  constexpr double n = BallSamples::kReplicates;
  const double share = sum / n;
  const double variance = std::max(0.0, squares / n - share * share) / (n - 1);
  const double sample = 1 / (n * each);
  const double error = replicates_error(variance, sample);
  return {share * ratio / (1 + ratio - share * ratio), error * iou_slope(share, ratio)};
}

}  // namespace uniquadric
