#include "estimator/ego/world_frame.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <vector>

#include "estimator/images/support_planes.h"
#include "estimator/shape/depth_point.h"

namespace uniquadric {
namespace {

constexpr int kMostPlanes = 6;  // walls may be larger than the floor
constexpr std::size_t kMinPoints = 200;

std::vector<Eigen::Vector3d> points_of(const cv::Mat& depth, const cv::Mat& masks, const Camera& camera,
                                       const UprightOptions& options) {
  std::vector<Eigen::Vector3d> points;
  for (int v = 0; v < depth.rows; v += options.step_px)
    for (int u = 0; u < depth.cols; u += options.step_px) {
      const float z = depth.at<float>(v, u);
      if (!(z > 0) || z > options.max_range_m || (!masks.empty() && masks.at<std::uint16_t>(v, u) != 0))
        continue;
      if (const auto point = depth_point(depth, camera, u, v)) points.push_back(*point);
    }
  return points;
}

}  // namespace

std::optional<Eigen::Vector3d> find_up(std::vector<Eigen::Vector3d> points, const Eigen::Vector3d& upright,
                                       const UprightOptions& options, RandomStream& random) {
  if (points.size() < kMinPoints) return std::nullopt;
  const double least = std::cos(options.max_tilt_deg * std::numbers::pi / 180);
  for (const Plane& plane :
       find_planes(std::move(points), options.plane_threshold_m, options.min_share, kMostPlanes, random)) {
    const double cosine = plane.normal.dot(upright);
    if (std::abs(cosine) >= least) return std::copysign(1, cosine) * plane.normal;
  }
  return std::nullopt;
}

std::optional<Eigen::Vector3d> find_up(const cv::Mat& depth, const cv::Mat& masks, const Camera& camera,
                                       const UprightOptions& options, RandomStream& random) {
  if (depth.empty()) return std::nullopt;
  return find_up(points_of(depth, masks, camera, options), -Eigen::Vector3d::UnitY(), options, random);
}

Pose upright_world_from_camera(const Eigen::Vector3d& up_in_camera) {
  const Eigen::Vector3d z = up_in_camera.normalized();
  const Eigen::Vector3d x = (Eigen::Vector3d::UnitX() - z.x() * z).normalized();
  Eigen::Matrix3d R;  // rows: the world's axes in the camera
  R << x.transpose(), z.cross(x).transpose(), z.transpose();
  return {Eigen::Quaterniond(R), Eigen::Vector3d::Zero()};
}

}  // namespace uniquadric
