#include "estimator/shape/accumulated_box.h"

#include <algorithm>
#include <cmath>

#include "estimator/shape/density_edge.h"

namespace uniquadric {
namespace {

// A convex body shows its furthest point to every camera beyond the plane that touches it there.
int count_views(const AccumulatedCloud& cloud, const Eigen::Vector3d& direction, double position_m,
                double min_sine) {
  const auto before = [&](const Eigen::Vector3d& camera) {
    const double height = direction.dot(camera) - position_m;
    return height > min_sine * (camera - position_m * direction).norm();
  };
  return static_cast<int>(std::count_if(cloud.cameras().begin(), cloud.cameras().end(), before));
}

std::optional<BodySide> side_of(const AccumulatedCloud& cloud, const Eigen::Matrix3Xd& points,
                                const Eigen::VectorXd& weights, const Eigen::Vector3d& direction,
                                const AccumulatedBoxOptions& options) {
  const double noise_m = std::sqrt(cloud.noise_variance(direction));
  const auto edge = upper_edge(points.transpose() * direction, weights, noise_m);
  if (!edge) return std::nullopt;
  BodySide side{direction, edge->position_m, 0, 0, false};
  side.views = count_views(cloud, direction, side.position_m, options.min_view_sine);
  side.seen = side.views > 0;
  const double pose_variance = options.pose_sigma_m * options.pose_sigma_m / std::max(side.views, 1);
  side.sigma_m = std::sqrt(edge->sigma_m * edge->sigma_m + pose_variance +
                           options.model_sigma_m * options.model_sigma_m);
  return side;
}

}  // namespace

std::optional<BodySide> accumulated_side(const AccumulatedCloud& cloud, const Eigen::Vector3d& direction,
                                         const AccumulatedBoxOptions& options) {
  const Eigen::VectorXd weights = cloud.weights();
  if (weights.sum() < options.min_cloud_weight) return std::nullopt;
  return side_of(cloud, cloud.points(), weights, direction, options);
}

std::optional<AccumulatedBox> accumulated_box(const AccumulatedCloud& cloud, const Eigen::Matrix3d& axes,
                                              const AccumulatedBoxOptions& options) {
  const Eigen::VectorXd weights = cloud.weights();
  if (weights.sum() < options.min_cloud_weight) return std::nullopt;
  const Eigen::Matrix3Xd points = cloud.points();
  AccumulatedBox box;
  box.axes = axes;
  for (int i = 0; i < 6; ++i) {
    const Eigen::Vector3d direction = (i % 2 ? -1 : 1) * axes.col(i / 2);
    const auto side = side_of(cloud, points, weights, direction, options);
    if (!side) return std::nullopt;
    box.sides[i] = *side;
  }
  return box;
}

double AccumulatedBox::half_extent_m(int axis) const {
  return (sides[2 * axis].position_m + sides[2 * axis + 1].position_m) / 2;
}

double AccumulatedBox::half_extent_sigma_m(int axis) const {
  return std::hypot(sides[2 * axis].sigma_m, sides[2 * axis + 1].sigma_m) / 2;
}

Eigen::Vector3d AccumulatedBox::center() const {
  Eigen::Vector3d along;
  for (int axis = 0; axis < 3; ++axis)
    along[axis] = (sides[2 * axis].position_m - sides[2 * axis + 1].position_m) / 2;
  return axes * along;
}

}  // namespace uniquadric
