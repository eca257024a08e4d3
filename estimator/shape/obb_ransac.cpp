#include "estimator/shape/obb_ransac.h"

#include <algorithm>
#include <numeric>
#include <vector>

#include "core/geometry/box_symmetry.h"

namespace uniquadric {
namespace {

// `count` different columns, by the first steps of a Fisher-Yates shuffle of `order`, which stays a
// permutation.
Eigen::Matrix3Xd random_sample(const Eigen::Matrix3Xd& points, int count, std::vector<int>& order,
                               RandomStream& random) {
  Eigen::Matrix3Xd sample(3, count);
  for (int i = 0; i < count; ++i) {
    const auto left = static_cast<std::uint32_t>(order.size() - i);
    std::swap(order[i], order[i + random.below(left)]);
    sample.col(i) = points.col(order[i]);
  }
  return sample;
}

OrientedBox fit_box(const Eigen::Matrix3Xd& sample, BoxFit fit) {
  if (fit == BoxFit::pca) return *fit_pca_box(sample);
  if (fit == BoxFit::tight_surface) return *fit_tight_surface_box(sample);
  return fit == BoxFit::surface ? *fit_surface_box(sample) : *fit_minimum_volume_box(sample);
}

int count_inliers(const Eigen::Matrix3Xd& points, const OrientedBox& box, const ObbOptions& options) {
  int inliers = 0;
  for (const auto& p : points.colwise()) {
    const double distance = options.inlier_distance == InlierDistance::surface ? distance_to_surface(box, p)
                                                                               : distance_to_corner(box, p);
    inliers += distance < options.inlier_threshold_m ? 1 : 0;
  }
  return inliers;
}

struct AxisStatistics {
  Eigen::Vector3d mean, deviation;
};

AxisStatistics axis_statistics(const std::vector<Eigen::Vector3d>& axes) {
  const auto n = static_cast<double>(axes.size());
  const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
  const Eigen::Vector3d mean = std::accumulate(axes.begin(), axes.end(), zero) / n;
  Eigen::Vector3d squares = zero;
  for (const auto& a : axes) squares += (a - mean).cwiseAbs2();
  return {mean, (squares / n).cwiseSqrt()};
}

Eigen::Vector3d blend(const AxisStatistics& axes, const Eigen::Vector3d& best, const ObbOptions& options) {
  const double w = options.best_weight;
  if (options.axis_rule == AxisRule::literal) return (1 - w) * axes.mean;  // l. 13's delta is zero
  return (1 - w) * axes.mean + w * best;
}

}  // namespace

std::optional<ObbEstimate> fit_obb_ransac(const Eigen::Matrix3Xd& points, const ObbOptions& options,
                                          const Eigen::Matrix3d& reference, RandomStream& random) {
  if (points.cols() < 4) return std::nullopt;
  const int sample_size = static_cast<int>(std::min<Eigen::Index>(options.sample_size, points.cols()));
  std::vector<int> order(points.cols());
  std::iota(order.begin(), order.end(), 0);
  ObbEstimate best;
  std::vector<Eigen::Vector3d> accepted;
  for (int t = 0; t < options.iterations; ++t) {
    const Eigen::Matrix3Xd sample = random_sample(points, sample_size, order, random);
    OrientedBox box = fit_box(sample, options.fit);
    const int inliers = count_inliers(points, box, options);
    if (inliers <= best.inliers) continue;
    if (options.canonicalise && !accepted.empty())
      box = relabel_axes(box, nearest_box_rotation(box.axes, best.box.axes));
    best.box = box;
    best.inliers = inliers;
    accepted.push_back(box.half_extents_m);
  }
  if (accepted.empty()) return std::nullopt;
  const AxisStatistics axes = axis_statistics(accepted);
  best.box.half_extents_m = blend(axes, best.box.half_extents_m, options).cwiseMax(options.min_semi_axis_m);
  const Eigen::Matrix3d P = nearest_box_rotation(best.box.axes, reference);
  best.box = relabel_axes(best.box, P);
  best.semi_axes_std_m = P.cwiseAbs().transpose() * axes.deviation;
  return best;
}

}  // namespace uniquadric
