#include "estimator/shape/reach.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <functional>

#include "core/base/quantile.h"

namespace uniquadric {
namespace {

constexpr int kRounds = 3;
constexpr double kTrim = 2.5, kFurthest = 0.98;
constexpr double kTop = 0.9;  // quantile of the facing points: the rest may be of what the body stands on
constexpr double kLeastOwn = 1e-9;       // share of a column: rounding leaves 1e-15
constexpr std::ptrdiff_t kLeastTop = 3;  // points that an end is the mean of, at least

using Quadratic = Eigen::Matrix<double, 6, 1>;

// The surface that a body ends in: heights over the plane across the direction, a quadratic in two
// coordinates.
struct EndSurface {
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, 6>;
  Rows rows;
  Eigen::VectorXd heights;
};

EndSurface end_surface(const Eigen::Matrix3Xd& points, const Eigen::Vector3d& direction, double above) {
  const Eigen::Vector3d u = direction.unitOrthogonal(), v = direction.cross(u);
  std::vector<Eigen::Index> in;
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    if (points.col(i).dot(direction) > above) in.push_back(i);
  EndSurface end{{std::ssize(in), 6}, Eigen::VectorXd(std::ssize(in))};
  for (std::size_t k = 0; k < in.size(); ++k) {
    const Eigen::Vector3d p = points.col(in[k]);
    const double x = p.dot(u), y = p.dot(v);
    end.rows.row(k) << 1, x, y, x * x, x * y, y * y;
    end.heights[k] = p.dot(direction);
  }
  return end;
}

// Points in one line (of a LiDAR) tell no surface: what a column has beside those before it is the diagonal.
bool tells_a_surface(const Eigen::HouseholderQR<EndSurface::Rows>& qr, const EndSurface::Rows& rows) {
  const Quadratic own = qr.matrixQR().diagonal().cwiseAbs(), whole = rows.colwise().norm().transpose();
  return (own.array() > kLeastOwn * whole.array()).all();
}

// `direction`: unit, in the camera's frame.
bool is_cut(const PointView& view, const Eigen::Vector3d& direction, double cosine) {
  return std::any_of(view.cut.begin(), view.cut.end(),
                     [&](const Eigen::Vector2d& side) { return side.dot(direction.head<2>()) > cosine; });
}

Eigen::Matrix3Xd facing_points(const PointView& view, const Eigen::Vector3d& direction, double min_cosine) {
  Eigen::Matrix3Xd facing(3, view.points->cols());
  Eigen::Index count = 0;
  for (Eigen::Index i = 0; i < view.points->cols(); ++i)
    if (view.normals->col(i).dot(direction) > min_cosine) facing.col(count++) = view.points->col(i);
  return facing.leftCols(count);
}

// The furthest points of a noisy surface lie beyond it. Where they belong to a surface that faces the
// direction, its own furthest point counts: of a quadratic through all of it.
std::optional<double> surface_end(const PointView& view, const Eigen::Vector3d& direction,
                                  const ReachOptions& options) {
  if (!view.normals || view.normals->cols() != view.points->cols()) return std::nullopt;
  const Eigen::Matrix3Xd facing = facing_points(view, direction, options.min_cosine);
  if (facing.cols() < options.min_points) return std::nullopt;
  const Eigen::VectorXd heights = view.points->transpose() * direction;
  const Eigen::VectorXd facing_heights = facing.transpose() * direction;
  const double top = quantile({facing_heights.begin(), facing_heights.end()}, kTop);
  const double depth = options.surface_depth * (top - heights.minCoeff());
  EndSurface end = end_surface(facing, direction, top - depth);
  double scatter = 0;
  for (int round = 0; round < kRounds; ++round) {
    if (end.heights.size() < options.min_points) return std::nullopt;
    const Eigen::HouseholderQR<EndSurface::Rows> qr(end.rows);
    if (!tells_a_surface(qr, end.rows)) return std::nullopt;
    const Quadratic fit = qr.solve(end.heights);
    const Eigen::VectorXd fitted = end.rows * fit, off = (end.heights - fitted).cwiseAbs();
    scatter = kMadToSigma * quantile({off.begin(), off.end()}, 0.5);
    if (scatter > options.max_scatter * depth) return std::nullopt;
    if (round + 1 == kRounds) {
      const double found = quantile({fitted.begin(), fitted.end()}, kFurthest);
      const auto beyond = (heights.array() > found + kTrim * scatter).count();
      if (static_cast<double>(beyond) > options.stray_share * static_cast<double>(heights.size()))
        return std::nullopt;
      return found;
    }
    EndSurface kept = end;
    Eigen::Index n = 0;
    for (Eigen::Index i = 0; i < off.size(); ++i) {
      if (off[i] > kTrim * scatter) continue;
      kept.rows.row(n) = end.rows.row(i);
      kept.heights[n++] = end.heights[i];
    }
    end = {kept.rows.topRows(n), kept.heights.head(n)};
  }
  return std::nullopt;
}

}  // namespace

double mean_of_furthest(const Eigen::Matrix3Xd& points, const Eigen::Vector3d& direction, double share) {
  Eigen::VectorXd along = points.transpose() * direction;
  const auto n = std::clamp<std::ptrdiff_t>(std::lround(share * static_cast<double>(along.size())), kLeastTop,
                                            along.size());
  std::nth_element(along.begin(), along.begin() + n - 1, along.end(), std::greater<>());
  return along.head(n).mean();
}

std::optional<Reach> reach_along(const std::vector<PointView>& views, const Eigen::Vector3d& direction,
                                 const ReachOptions& options) {
  std::vector<double> all, shown;
  bool always_cut = true;
  for (const PointView& view : views) {
    if (view.points->cols() < kLeastTop) continue;
    const Eigen::Vector3d in_camera = view.body_from_camera.rotation.conjugate() * direction;
    const double camera = direction.dot(view.body_from_camera.translation);
    const double top = mean_of_furthest(*view.points, in_camera, options.top_share);
    const double end = surface_end(view, in_camera, options).value_or(top) + camera;
    all.push_back(end);
    const double range = view.points->rowwise().mean().norm();
    const bool cut = is_cut(view, in_camera, options.cut_cosine);
    always_cut = always_cut && is_cut(view, in_camera, options.cut_off_cosine);
    if (!cut && camera - end > options.min_sine * range) shown.push_back(end);
  }
  if (all.empty()) return std::nullopt;
  if (shown.empty()) return Reach{quantile(all, options.least_quantile), 0, always_cut};
  Reach reach{quantile(shown, 0.5), static_cast<int>(std::ssize(shown))};
  for (double& end : shown) end = std::abs(end - reach.position_m);
  reach.spread_m = kMadToSigma * quantile(std::move(shown), 0.5);
  return reach;
}

}  // namespace uniquadric
