#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "core/geometry/ellipsoid.h"
#include "evaluation/iou/shifted_sequence.h"

namespace uniquadric {

/// Points spread evenly over the unit ball: kReplicates randomly shifted copies of a low-discrepancy
/// sequence, one after the other. Keep one for many pairs: making it costs more than using it.
class BallSamples {
 public:
  static constexpr int kReplicates = uniquadric::kReplicates;
  /// `samples` is rounded up to a multiple of kReplicates. The same seed gives the same points.
  BallSamples(int samples, std::uint64_t seed);
  int size() const { return static_cast<int>(x().size()); }
  int per_replicate() const { return size() / kReplicates; }
  Eigen::Vector3d point(int i) const { return {x()[i], y()[i], z()[i]}; }
  /// Coordinates of all points, apart: so loops take several points at once.
  const Eigen::VectorXd& x() const { return columns_[0]; }
  const Eigen::VectorXd& y() const { return columns_[1]; }
  const Eigen::VectorXd& z() const { return columns_[2]; }

 private:
  std::array<Eigen::VectorXd, 3> columns_;
};

struct MonteCarloIou {
  double iou = 0;
  /// 0 for identical bodies, else from the spread over the replicates. Their number is finite (Student's t),
  /// and where a few samples decide, hits or misses, those that happen to be fewer than expected also state a
  /// spread that is too small: two samples are counted beside those that were seen, as Agresti and Coull have
  /// it ("Approximate is better than exact", 1998). So errors of 5 of these are as rare as they should be for
  /// any overlap; the estimate itself is left as it is.
  double standard_error = 0;
};

/// The paper's Monte Carlo estimate of the intersection over union: the share of the smaller body's points
/// that lie in the larger one. Symmetric in its arguments, exactly 1 for identical ones.
MonteCarloIou ellipsoid_iou_monte_carlo(const Ellipsoid& a, const Ellipsoid& b, const BallSamples& samples);

}  // namespace uniquadric
