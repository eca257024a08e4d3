#include "evaluation/iou/shifted_sequence.h"

#include <cmath>

#include "core/base/random.h"

namespace uniquadric {
namespace {

// Additive recurrence by the root of x^4 = x + 1, the three-dimensional golden ratio (M. Roberts, "The
// unreasonable effectiveness of quasirandom sequences", 2018).
constexpr double kGolden3 = 1.2207440846057596;
// Mean square of Student's t of as many degrees of freedom as the replicates leave.
constexpr double kFewReplicates = (kReplicates - 1.0) / (kReplicates - 3.0);
constexpr double kSamplesBeside = 2;  // Agresti and Coull: at 95 %

}  // namespace

std::vector<Eigen::Vector3d> shifted_sequence(int count, std::uint64_t seed, std::string_view name,
                                              int replicate) {
  const Eigen::Array3d step(1 / kGolden3, 1 / (kGolden3 * kGolden3), 1 / (kGolden3 * kGolden3 * kGolden3));
  RandomStream random(seed, name, static_cast<std::uint64_t>(replicate));
  const double x = random.uniform(), y = random.uniform(), z = random.uniform();
  std::vector<Eigen::Vector3d> points;
  points.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    const Eigen::Array3d u = Eigen::Array3d(x, y, z) + i * step;
    points.emplace_back((u - u.floor()).matrix());
  }
  return points;
}

double replicates_error(double variance_of_mean, double of_sample) {
  return std::sqrt(kFewReplicates * variance_of_mean + kSamplesBeside * of_sample * of_sample);
}

}  // namespace uniquadric
