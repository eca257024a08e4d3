#include "estimator/shape/reach.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace uniquadric {
namespace {

constexpr std::ptrdiff_t kLeastTop = 3;  // points that an end is the mean of, at least

// Mean of the furthest points along a direction of the camera frame.
double top_mean(const Eigen::Matrix3Xd& points, const Eigen::Vector3d& direction, double share) {
  Eigen::VectorXd along = points.transpose() * direction;
  const auto n = std::clamp<std::ptrdiff_t>(std::lround(share * static_cast<double>(along.size())), kLeastTop,
                                            along.size());
  std::nth_element(along.begin(), along.begin() + n - 1, along.end(), std::greater<>());
  return along.head(n).mean();
}

double quantile(std::vector<double> values, double q) {
  const auto at = static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[at];
}

}  // namespace

std::optional<Reach> reach_along(const std::vector<PointView>& views, const Eigen::Vector3d& direction,
                                 const ReachOptions& options) {
  std::vector<double> all, shown;
  for (const PointView& view : views) {
    if (view.points->cols() < kLeastTop) continue;
    const Eigen::Vector3d in_camera = view.body_from_camera.rotation.conjugate() * direction;
    const double camera = direction.dot(view.body_from_camera.translation);
    const double end = top_mean(*view.points, in_camera, options.top_share) + camera;
    all.push_back(end);
    const double range = view.points->rowwise().mean().norm();
    if (view.whole && camera - end > options.min_sine * range) shown.push_back(end);
  }
  if (all.empty()) return std::nullopt;
  if (shown.empty()) return Reach{quantile(all, options.least_quantile), 0};
  return Reach{quantile(shown, 0.5), static_cast<int>(std::ssize(shown))};
}

}  // namespace uniquadric
