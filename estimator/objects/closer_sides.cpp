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

// The box along other axes, named as its own. Where views do not show its ends, they are the shape's.
Shape box_along_axes(const Shape& shape, const Eigen::Quaterniond& axes, const SideEvidence& evidence) {
  Shape box = shape;
  box.body_from_object.rotation = axes;
  return with_seen_extents(box, evidence.views, evidence.radius_m, evidence.contacts, Lengths::assumed);
}

}  // namespace

bool has_closer_sides(const Shape& other, const Shape& best, const SideEvidence& evidence) {
  return share_off_box(other, evidence) < kCloser * share_off_box(best, evidence);
}

std::optional<Shape> box_about(const Shape& shape, const std::optional<Shape>& before, bool looks,
                               const SideEvidence& evidence) {
  if (evidence.surface_points.cols() == 0 || (!before && !looks)) return std::nullopt;
  const auto volume_along = [&](const Eigen::Quaterniond& axes) {
    return box_along(axes.toRotationMatrix(), evidence.surface_points).half_extents_m.prod();
  };
  const Eigen::Quaterniond& own_axes = shape.body_from_object.rotation;
  const double own_volume = volume_along(own_axes), own_off = share_off_sides(shape, evidence);
  const double surface_off = share_off_surface(shape, evidence);
  const auto box_with = [&](const Eigen::Quaterniond& axes, double most_off) -> std::optional<Shape> {
    const Shape box = box_along_axes(shape, axes, evidence);
    const double off = share_off_sides(box, evidence);
    if (off >= most_off || surface_off < kCloser * off) return std::nullopt;
    return box;
  };
  std::optional<Shape> held;
  if (before && volume_along(before->body_from_object.rotation) < own_volume)
    held = box_with(before->body_from_object.rotation, own_off / kCloser);
  const auto seen = looks ? fit_tight_surface_box(evidence.surface_points) : std::nullopt;
  const Eigen::Quaterniond& axes = held ? held->body_from_object.rotation : own_axes;
  if (!seen || seen->half_extents_m.prod() >= kCloser * volume_along(axes)) return held;
  const Eigen::Matrix3d named = seen->axes * nearest_box_rotation(seen->axes, axes.toRotationMatrix());
  const auto found = box_with(Eigen::Quaterniond(named).normalized(), own_off);
  return found ? found : held;
}

}  // namespace uniquadric
