#include "estimator/objects/closer_sides.h"

#include <algorithm>

#include "estimator/objects/seen_extents.h"

namespace uniquadric {
namespace {

constexpr double kCloser = 0.9;     // share of the points off a box below which another is closer
constexpr double kNearSide = 0.05;  // radii that a point may be off a side

double share_off_box(const Shape& shape, const SideEvidence& evidence) {
  const Shape box = with_seen_extents(shape, evidence.views, evidence.radius_m, evidence.contacts);
  const Pose box_from_body = box.body_from_object.inverse();
  const double near_m = kNearSide * evidence.radius_m;
  double off = 0;
  for (const auto& point : evidence.surface_points.colwise()) {
    const Eigen::Vector3d x = box_from_body * Eigen::Vector3d(point);
    const double ratio = (x.cwiseAbs() - box.semi_axes_m).cwiseAbs().minCoeff() / near_m;
    off += ratio * ratio / (1 + ratio * ratio);
  }
  return off / std::max(1.0, static_cast<double>(evidence.surface_points.cols()));
}

}  // namespace

bool has_closer_sides(const Shape& other, const Shape& best, const SideEvidence& evidence) {
  return share_off_box(other, evidence) < kCloser * share_off_box(best, evidence);
}

}  // namespace uniquadric
