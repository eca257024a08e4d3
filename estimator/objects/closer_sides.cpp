#include "estimator/objects/closer_sides.h"

#include <algorithm>

#include "core/geometry/box_symmetry.h"
#include "core/geometry/superquadric.h"
#include "estimator/objects/seen_extents.h"
#include "estimator/shape/oriented_box.h"

namespace uniquadric {
namespace {

constexpr double kCloser = 0.9;     // share of the points off a box below which another is closer
constexpr double kNearSide = 0.05;  // radii that a point may be off a side

// Share of the surface's points that are further off than is near. `distance_m`: of a point in the shape's
// frame.
template <typename Distance>
double share_off(const Shape& shape, const SideEvidence& evidence, const Distance& distance_m) {
  const Pose shape_from_body = shape.body_from_object.inverse();
  const double near_m = kNearSide * evidence.radius_m;
  double off = 0;
  for (const auto& point : evidence.surface_points.colwise()) {
    const double ratio = distance_m(shape_from_body * Eigen::Vector3d(point)) / near_m;
    off += ratio * ratio / (1 + ratio * ratio);
  }
  return off / std::max(1.0, static_cast<double>(evidence.surface_points.cols()));
}

double share_off_sides(const Shape& box, const SideEvidence& evidence) {
  return share_off(box, evidence, [&](const Eigen::Vector3d& x) {
    return (x.cwiseAbs() - box.semi_axes_m).cwiseAbs().minCoeff();
  });
}

// Off the shape's own surface, along the line from its middle.
double share_off_surface(const Shape& shape, const SideEvidence& evidence) {
  const Superellipsoid body = shape.superellipsoid();
  return share_off(shape, evidence, [&](const Eigen::Vector3d& x) {
    const double scale = gauge(body, x);
    return scale > 0 ? x.norm() * (1 - 1 / scale) : body.semi_axes_m.minCoeff();
  });
}

double share_off_box(const Shape& shape, const SideEvidence& evidence) {
  return share_off_sides(with_seen_extents(shape, evidence.views, evidence.radius_m, evidence.contacts),
                         evidence);
}

// The box along other axes (columns), named as its own. Where views do not show its ends, they are the
// shape's.
Shape box_along_axes(const Shape& shape, const Eigen::Matrix3d& axes, const SideEvidence& evidence) {
  Shape box = shape;
  box.body_from_object.rotation = Eigen::Quaterniond(axes).normalized();
  return with_seen_extents(box, evidence.views, evidence.radius_m, evidence.contacts, false);
}

}  // namespace

bool has_closer_sides(const Shape& other, const Shape& best, const SideEvidence& evidence) {
  return share_off_box(other, evidence) < kCloser * share_off_box(best, evidence);
}

Shape box_about(const Shape& shape, std::optional<Eigen::Matrix3d>& axes, bool looks,
                const SideEvidence& evidence) {
  if (evidence.surface_points.cols() == 0 || (!axes && !looks)) return shape;
  const auto volume_along = [&](const Eigen::Matrix3d& along) {
    return box_along(along, evidence.surface_points).half_extents_m.prod();
  };
  const Eigen::Matrix3d own_axes = shape.body_from_object.rotation.toRotationMatrix();
  const double own_volume = volume_along(own_axes), own_off = share_off_sides(shape, evidence);
  const double surface_off = share_off_surface(shape, evidence);
  Shape best = shape;
  const auto takes = [&](const Eigen::Matrix3d& along, double most_off) {
    const Shape box = box_along_axes(shape, along, evidence);
    const double off = share_off_sides(box, evidence);
    if (off >= most_off || surface_off < kCloser * off) return false;
    best = box;
    return true;
  };
  if (axes && !(volume_along(*axes) < own_volume && takes(*axes, own_off / kCloser))) axes.reset();
  const auto seen = looks ? fit_tight_surface_box(evidence.surface_points) : std::nullopt;
  if (!seen || seen->half_extents_m.prod() >= kCloser * (axes ? volume_along(*axes) : own_volume))
    return best;
  const Eigen::Matrix3d named = seen->axes * nearest_box_rotation(seen->axes, axes.value_or(own_axes));
  if (takes(named, own_off)) axes = named;
  return best;
}

}  // namespace uniquadric
