#include "evaluation/trajectory/kitti.h"

#include <algorithm>
#include <numbers>

namespace uniquadric {
namespace {

constexpr std::size_t kStartEvery = 10;  // the benchmark's: a second at its 10 frames a second
constexpr int kLengths = 8;
constexpr double kLengthStep_m = 100;

// Sums while parts are added, means after `divide`.
void add(KittiErrors& sum, const PoseError& error, double length_m) {
  sum.translation_percent += 100 * error.translation_m / length_m;
  sum.rotation_deg_per_100m += error.rotation_rad * 180 / std::numbers::pi * 100 / length_m;
  ++sum.parts;
}

void divide(KittiErrors& sum) {
  sum.translation_percent /= static_cast<double>(sum.parts);
  sum.rotation_deg_per_100m /= static_cast<double>(sum.parts);
}

}  // namespace

std::optional<KittiOdometry> kitti_odometry(const PosePairs& poses) {
  const std::vector<double> along_m = path_lengths_m(poses.reference);
  KittiOdometry result;
  for (int n = 1; n <= kLengths; ++n) {
    KittiLength length{n * kLengthStep_m, {}};
    for (std::size_t i = 0; i < poses.size(); i += kStartEvery) {
      const auto end = std::upper_bound(along_m.begin(), along_m.end(), along_m[i] + length.length_m);
      if (end == along_m.end()) break;
      const auto j = static_cast<std::size_t>(end - along_m.begin());
      const PoseError error =
          relative_error(poses.reference[i], poses.reference[j], poses.estimate[i], poses.estimate[j]);
      add(length.errors, error, length.length_m);
      add(result.mean, error, length.length_m);
    }
    if (length.errors.parts == 0) continue;
    divide(length.errors);
    result.lengths.push_back(length);
  }
  if (result.mean.parts == 0) return std::nullopt;
  divide(result.mean);
  return result;
}

}  // namespace uniquadric
