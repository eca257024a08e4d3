#include "estimator/objects/outline_reach.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "core/base/quantile.h"

namespace uniquadric {
namespace {

// All ours.
constexpr double kFacing = 0.866;     // cosine of a tangent's normal to the axis that it tells of: 30 degrees
constexpr int kSights = 5;            // lines of sight that stand for all between which a tangent touches
constexpr int kBeside = 8;            // points next to a line of sight that say where it meets the body
constexpr double kNextTo = 0.2;       // share of the way to the body's middle that these are off at most
constexpr double kFacingSight = 0.2;  // cosine of a normal to it from which on its plane says so
constexpr double kBestViews = 0.9;  // quantile of the views: each says the least, some much less than others

Eigen::Vector3d crossing(const Camera& camera, const SupportLine& a, const SupportLine& b) {
  Eigen::Matrix2d normals;
  normals << a.normal.transpose(), b.normal.transpose();
  const Eigen::Vector2d pixel = normals.inverse() * Eigen::Vector2d(a.offset_px, b.offset_px);
  return camera.matrix().inverse() * pixel.homogeneous();
}

// Least coordinate along the axis, times the sign, of a line of sight where it is within the shape's box in
// the other axes. All in the shape's frame; nothing where it passes the box.
// `nearest`: as a multiple of `sight`, before which it is not in the body.
std::optional<double> least_within(const Eigen::Vector3d& semi_axes_m, const Eigen::Vector3d& camera,
                                   const Eigen::Vector3d& sight, double nearest, int axis, int sign) {
  double first = 0, last = std::numeric_limits<double>::infinity();
  for (const int other : {(axis + 1) % 3, (axis + 2) % 3}) {
    const double to_face = -camera[other] / sight[other], half = std::abs(semi_axes_m[other] / sight[other]);
    first = std::max(first, to_face - half);
    last = std::min(last, to_face + half);
  }
  if (!(first < last)) return std::nullopt;
  first = std::clamp(nearest, first, last);
  return sign * camera[axis] + std::min(first * sign * sight[axis], last * sign * sight[axis]);
}

const OutlineTouch* most_facing(const PointView& view, const Eigen::Vector3d& direction) {
  const auto facing = [&](const OutlineTouch& touch) { return touch.normal.dot(direction); };
  const auto most = std::max_element(view.touches.begin(), view.touches.end(),
                                     [&](const auto& a, const auto& b) { return facing(a) < facing(b); });
  return most != view.touches.end() && facing(*most) > kFacing ? &*most : nullptr;
}

// The points that are nearest to a line of sight, nearest first: the squared distance of the unit vectors,
// and which point it is.
std::array<std::pair<double, Eigen::Index>, kBeside> beside(const PointView& view,
                                                            const Eigen::Vector3d& along) {
  std::vector<std::pair<double, Eigen::Index>> all;
  all.reserve(static_cast<std::size_t>(view.rays.cols()));
  for (Eigen::Index i = 0; i < view.rays.cols(); ++i)
    all.emplace_back((view.rays.col(i) - along).squaredNorm(), i);
  std::array<std::pair<double, Eigen::Index>, kBeside> nearest;
  std::ranges::partial_sort_copy(all, nearest);
  return nearest;
}

// Where a line of sight at the rim may meet a body at the earliest: a convex one lies behind the surface that
// is seen next to it, and behind the planes that touch that.
double nearest_at(const PointView& view, const Eigen::Vector3d& sight) {
  if (!view.normals || view.normals->cols() != view.points->cols() || view.points->cols() < kBeside) return 0;
  const Eigen::Vector3d along = sight.normalized();
  const auto nearest = beside(view, along);
  const double reach2 = (view.points->rowwise().mean().normalized() - along).squaredNorm();
  if (nearest.back().first > kNextTo * kNextTo * reach2) return 0;  // a LiDAR's are far apart
  std::vector<double> met;
  for (const auto& [off2, i] : nearest) {
    const Eigen::Vector3d p = view.points->col(i), n = view.normals->col(i);
    const double facing = n.dot(along);
    met.push_back(facing < -kFacingSight ? n.dot(p) / facing : along.dot(p));
  }
  return quantile(met, 0.5) / sight.norm();
}

std::optional<double> reach_of_view(const Shape& shape, const PointView& view, int axis, int sign) {
  const Pose shape_from_camera = shape.body_from_object.inverse() * view.body_from_camera;
  const Eigen::Matrix3d R = shape_from_camera.rotation.toRotationMatrix();
  const OutlineTouch* touch = most_facing(view, sign * R.row(axis).transpose());
  if (!touch) return std::nullopt;
  std::optional<double> least;
  for (int i = 0; i < kSights; ++i) {
    const Eigen::Vector3d sight = touch->from + (touch->to - touch->from) * i / (kSights - 1);
    if (!sight.allFinite()) continue;  // of two tangents that are parallel
    const auto end = least_within(shape.semi_axes_m, shape_from_camera.translation, R * sight,
                                  nearest_at(view, sight), axis, sign);
    if (end && (!least || *end < *least)) least = end;
  }
  return least;
}

}  // namespace

std::vector<OutlineTouch> outline_touches(const Camera& camera, const Silhouette& silhouette) {
  std::vector<OutlineTouch> touches;
  const auto& lines = silhouette.support;
  const std::size_t n = lines.size();
  for (std::size_t i = 0; i < n; ++i) {
    if (!lines[i].free) continue;
    const Eigen::Vector3d line(lines[i].normal.x(), lines[i].normal.y(), -lines[i].offset_px);
    touches.push_back({(camera.matrix().transpose() * line).normalized(),
                       crossing(camera, lines[(i + n - 1) % n], lines[i]),
                       crossing(camera, lines[i], lines[(i + 1) % n])});
  }
  return touches;
}

std::optional<double> reach_by_outlines(const Shape& shape, const std::vector<PointView>& views, int axis,
                                        int sign) {
  std::vector<double> ends;
  for (const PointView& view : views)
    if (const auto end = reach_of_view(shape, view, axis, sign)) ends.push_back(*end);
  if (ends.empty()) return std::nullopt;
  return quantile(ends, kBestViews);
}

}  // namespace uniquadric
