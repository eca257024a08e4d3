#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/geometry/ellipsoid.h"

namespace uniquadric {

/// Points spread evenly over the unit ball: kReplicates randomly shifted copies of a low-discrepancy
/// sequence, one after the other. Keep one for many pairs: making it costs more than using it.
class BallSamples {
 public:
  static constexpr int kReplicates = 32;
  /// `samples` is rounded up to a multiple of kReplicates. The same seed gives the same points.
  BallSamples(int samples, std::uint64_t seed);
  const std::vector<Eigen::Vector3d>& points() const { return points_; }
  int per_replicate() const { return static_cast<int>(points_.size()) / kReplicates; }

 private:
  std::vector<Eigen::Vector3d> points_;
};

struct MonteCarloIou {
  double iou = 0;
  double standard_error =
      0;  ///< from the spread over the replicates; 0 for identical bodies, else at least one sample
};

/// The paper's Monte Carlo estimate of the intersection over union: the share of the smaller body's points
/// that lie in the larger one. Symmetric in its arguments, exactly 1 for identical ones.
MonteCarloIou ellipsoid_iou_monte_carlo(const Ellipsoid& a, const Ellipsoid& b, const BallSamples& samples);

}  // namespace uniquadric
