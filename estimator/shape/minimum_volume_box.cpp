#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "estimator/shape/oriented_box.h"

namespace uniquadric {
namespace {

constexpr int kPlaneStarts = 6;  // ours: one of six triples lies on one face of three with 0.6 probability
constexpr int kMaxSweeps = 10;   // ours: sweeps over the axes; four are the most that was seen
constexpr double kVolumeDecrease = 1e-6;  // relative: less is no progress
constexpr double kThinnest = 1e-9;        // m: keeps the volumes of flat clouds comparable

double cross(const Eigen::Vector2d& o, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return (a.x() - o.x()) * (b.y() - o.y()) - (a.y() - o.y()) * (b.x() - o.x());
}

// Convex hull, counter-clockwise, without collinear points (Andrew's monotone chain).
std::vector<Eigen::Vector2d> convex_hull(std::vector<Eigen::Vector2d> points) {
  std::sort(points.begin(), points.end(),
            [](const auto& a, const auto& b) { return std::pair(a.x(), a.y()) < std::pair(b.x(), b.y()); });
  std::vector<Eigen::Vector2d> hull;
  const auto chain = [&](auto begin, auto end) {
    const std::size_t first = hull.size();
    for (auto p = begin; p != end; ++p) {
      while (hull.size() >= first + 2 && cross(hull[hull.size() - 2], hull.back(), *p) <= 0) hull.pop_back();
      hull.push_back(*p);
    }
    hull.pop_back();  // the next chain starts with it
  };
  chain(points.begin(), points.end());
  chain(points.rbegin(), points.rend());
  return hull;
}

// Direction of a side of the least rectangle around a hull: one of the hull's own edges.
Eigen::Vector2d least_rectangle_side(const std::vector<Eigen::Vector2d>& hull) {
  Eigen::Vector2d best = Eigen::Vector2d::UnitX();
  double best_area = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Eigen::Vector2d edge = hull[(i + 1) % hull.size()] - hull[i];
    if (!(edge.norm() > 0)) continue;
    const Eigen::Vector2d along = edge.normalized(), across(-along.y(), along.x());
    Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity()), high = -low;
    for (const auto& p : hull) {
      const Eigen::Vector2d q(along.dot(p), across.dot(p));
      low = low.cwiseMin(q);
      high = high.cwiseMax(q);
    }
    const double area = (high - low).prod();
    if (area < best_area) best_area = area, best = along;
  }
  return best;
}

// Turns the axes about axis k to the least rectangle of the points projected along it.
Eigen::Matrix3d turn_about(int k, const Eigen::Matrix3d& axes, const Eigen::Matrix3Xd& points) {
  const int i = (k + 1) % 3, j = (k + 2) % 3;
  std::vector<Eigen::Vector2d> flat(points.cols());
  for (Eigen::Index n = 0; n < points.cols(); ++n)
    flat[n] = {axes.col(i).dot(points.col(n)), axes.col(j).dot(points.col(n))};
  const Eigen::Vector2d side = least_rectangle_side(convex_hull(std::move(flat)));
  Eigen::Matrix3d turned = axes;
  turned.col(i) = (side.x() * axes.col(i) + side.y() * axes.col(j)).normalized();
  turned.col(j) = axes.col(k).cross(turned.col(i));
  return turned;
}

double volume(const OrientedBox& box) {
  return box.half_extents_m.cwiseMax(kThinnest).prod();
}

OrientedBox shrink(OrientedBox box, const Eigen::Matrix3Xd& points) {
  for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
    const double before = volume(box);
    for (int k = 0; k < 3; ++k) {
      const OrientedBox turned = box_along(turn_about(k, box.axes, points), points);
      if (volume(turned) < volume(box)) box = turned;
    }
    if (!(volume(box) < before * (1 - kVolumeDecrease))) break;
  }
  return box;
}

// Axes with the normal of the plane through three points as the last; nothing for collinear points.
std::optional<Eigen::Matrix3d> plane_axes(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                          const Eigen::Vector3d& c) {
  const Eigen::Vector3d normal = (b - a).cross(c - a);
  if (!(normal.norm() > 0)) return std::nullopt;
  Eigen::Matrix3d axes;
  axes.col(2) = normal.normalized();
  axes.col(0) = axes.col(2).unitOrthogonal();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return axes;
}

}  // namespace

std::optional<OrientedBox> fit_minimum_volume_box(const Eigen::Matrix3Xd& points) {
  const auto start = fit_pca_box(points);
  if (!start) return std::nullopt;
  const Eigen::Vector3d offset = points.rowwise().mean();  // far from the origin digits would be lost
  const Eigen::Matrix3Xd centred = points.colwise() - offset;
  OrientedBox best = shrink(box_along(start->axes, centred), centred);
  const Eigen::Index step = std::max<Eigen::Index>(points.cols() / (3 * kPlaneStarts), 1);
  for (int n = 0; n < kPlaneStarts; ++n) {
    const auto point = [&](int m) { return centred.col((3 * n + m) * step % centred.cols()); };
    const auto axes = plane_axes(point(0), point(1), point(2));
    if (!axes) continue;
    const OrientedBox box = shrink(box_along(turn_about(2, *axes, centred), centred), centred);
    if (volume(box) < volume(best)) best = box;
  }
  best.center += offset;
  return best;
}

}  // namespace uniquadric
