#include <Eigen/Geometry>
#include <algorithm>
#include <utility>
#include <vector>

#include "estimator/shape/oriented_box.h"

namespace uniquadric {
namespace {

constexpr int kPlaneStarts = 3;      // ours: six found no better boxes on the tested clouds
constexpr int kMaxSweeps = 10;       // ours: sweeps over the axes; four are the most that was seen
constexpr double kDecrease = 1e-6;   // relative: less is no progress
constexpr double kTightness = 0.02;  // ours: a face turned by 0.1 rad in itself costs a millimetre at 0.5 m
constexpr double kThinnest = 1e-9;   // m: keeps the volumes of flat clouds comparable

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

double volume(const OrientedBox& box, const Eigen::Matrix3Xd&) {
  return box.half_extents_m.cwiseMax(kThinnest).prod();
}

double mean_surface_distance(const OrientedBox& box, const Eigen::Matrix3Xd& points) {
  double sum = 0;
  for (const auto& p : points.colwise()) sum += distance_to_surface(box, p);
  return sum / static_cast<double>(points.cols());
}

// A single face says nothing of the turn about its normal; of boxes whose surface fits alike the smaller one
// is it.
double tight_surface_distance(const OrientedBox& box, const Eigen::Matrix3Xd& points) {
  return mean_surface_distance(box, points) + kTightness * box.half_extents_m.sum();
}

using Cost = double (*)(const OrientedBox&, const Eigen::Matrix3Xd&);

struct Candidate {
  OrientedBox box;
  double cost = 0;
};

Candidate candidate(const Eigen::Matrix3d& axes, const Eigen::Matrix3Xd& points, Cost cost) {
  const OrientedBox box = box_along(axes, points);
  return {box, cost(box, points)};
}

// The best of the boxes turned about axis k to be flush with an edge of the hull of the points projected
// along it.
Candidate turn_about(int k, const Candidate& start, const Eigen::Matrix3Xd& points, Cost cost) {
  const Eigen::Matrix3d& axes = start.box.axes;
  const int i = (k + 1) % 3, j = (k + 2) % 3;
  std::vector<Eigen::Vector2d> flat(points.cols());
  for (Eigen::Index n = 0; n < points.cols(); ++n)
    flat[n] = {axes.col(i).dot(points.col(n)), axes.col(j).dot(points.col(n))};
  const auto hull = convex_hull(std::move(flat));
  Candidate best = start;
  for (std::size_t n = 0; n < hull.size(); ++n) {
    const Eigen::Vector2d edge = hull[(n + 1) % hull.size()] - hull[n];
    if (!(edge.norm() > 0)) continue;
    Eigen::Matrix3d turned = axes;
    turned.col(i) = (edge.x() * axes.col(i) + edge.y() * axes.col(j)).normalized();
    turned.col(j) = axes.col(k).cross(turned.col(i));
    const Candidate other = candidate(turned, points, cost);
    if (other.cost < best.cost) best = other;
  }
  return best;
}

Candidate descend(const Eigen::Matrix3d& axes, const Eigen::Matrix3Xd& points, Cost cost) {
  Candidate best = turn_about(2, candidate(axes, points, cost), points, cost);
  for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
    const double before = best.cost;
    for (int k = 0; k < 3; ++k) best = turn_about(k, best, points, cost);
    if (!(best.cost < before * (1 - kDecrease))) break;
  }
  return best;
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

std::optional<OrientedBox> fit_tight_box(const Eigen::Matrix3Xd& points, Cost cost) {
  const auto start = fit_pca_box(points);
  if (!start) return std::nullopt;
  const Eigen::Vector3d offset = points.rowwise().mean();  // far from the origin digits would be lost
  const Eigen::Matrix3Xd centred = points.colwise() - offset;
  Candidate best = descend(start->axes, centred, cost);
  const Eigen::Index step = std::max<Eigen::Index>(points.cols() / (3 * kPlaneStarts), 1);
  for (int n = 0; n < kPlaneStarts; ++n) {
    const auto point = [&](int m) { return centred.col((3 * n + m) * step % centred.cols()); };
    const auto axes = plane_axes(point(0), point(1), point(2));
    if (!axes) continue;
    const Candidate other = descend(*axes, centred, cost);
    if (other.cost < best.cost) best = other;
  }
  best.box.center += offset;
  return best.box;
}

}  // namespace

std::optional<OrientedBox> fit_minimum_volume_box(const Eigen::Matrix3Xd& points) {
  return fit_tight_box(points, volume);
}

std::optional<OrientedBox> fit_tight_surface_box(const Eigen::Matrix3Xd& points) {
  return fit_tight_box(points, tight_surface_distance);
}

std::optional<OrientedBox> fit_surface_box(const Eigen::Matrix3Xd& points) {
  return fit_tight_box(points, mean_surface_distance);
}

}  // namespace uniquadric
