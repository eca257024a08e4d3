#include "estimator/objects/beside_outlines.h"

#include <algorithm>

namespace uniquadric {
namespace {

// Both ours.
constexpr double kBeside_px = 3;      // beyond a segmented outline, which is off by 1 to 2
constexpr double kBesideShare = 0.5;  // of those outlines: a pose may be off

bool is_beside(const Camera& camera, const Silhouette& silhouette, const Eigen::Vector3d& in_camera) {
  if (in_camera.z() <= 0) return false;
  const Eigen::Vector2d pixel = (camera.matrix() * in_camera).hnormalized();
  return std::any_of(silhouette.support.begin(), silhouette.support.end(), [&](const SupportLine& line) {
    return line.free && line.normal.dot(pixel) > line.offset_px + kBeside_px;
  });
}

Eigen::Matrix3Xd without(const std::vector<bool>& left_out, const Eigen::Matrix3Xd& points) {
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    if (!left_out[static_cast<std::size_t>(i)]) kept.push_back(i);
  return points(Eigen::all, kept);
}

Eigen::Matrix3Xd moved(const Pose& pose, const Eigen::Matrix3Xd& points) {
  return (pose.rotation.toRotationMatrix() * points).colwise() + pose.translation;
}

}  // namespace

std::vector<bool> beside_outlines(const Camera& camera, const std::vector<ShapeView>& views,
                                  const Eigen::Matrix3Xd& points) {
  std::vector<int> beside(static_cast<std::size_t>(points.cols()));
  int segmented = 0;
  for (const ShapeView& view : views) {
    if (!view.silhouette.segmented) continue;
    ++segmented;
    const Eigen::Matrix3Xd seen = moved(view.world_from_camera.inverse() * view.world_from_body, points);
    for (std::size_t i = 0; i < beside.size(); ++i)
      beside[i] += is_beside(camera, view.silhouette, seen.col(static_cast<Eigen::Index>(i)));
  }
  std::vector<bool> result;
  for (const int count : beside) result.push_back(count > 0 && count >= kBesideShare * segmented);
  return result;
}

void drop_beside_outlines(const Camera& camera, std::vector<ShapeView>& views, Eigen::Matrix3Xd& points) {
  points = without(beside_outlines(camera, views, points), points);
  for (ShapeView& view : views) {
    if (!view.silhouette.segmented) continue;
    std::vector<bool> beside;
    for (const auto& p : view.points.colwise()) beside.push_back(is_beside(camera, view.silhouette, p));
    view.points = without(beside, view.points);
    if (view.normals.cols() > 0) view.normals = without(beside, view.normals);
  }
}

}  // namespace uniquadric
