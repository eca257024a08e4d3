#include "estimator/shape/view_extents.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/quantile.h"

namespace uniquadric {
namespace {

constexpr Eigen::Index kLeastPoints = 30;
constexpr double kRoundDoubt = 0.3;  // share of what an ellipsoid hides by which an egg may hide more or less

// An end that faces the camera is seen itself, one that does not ends at the outline.
double rim_weight(double towards, const ViewExtentOptions& options) {
  return std::clamp(1 - towards / options.near_cosine, 0.0, 1.0);
}

ViewExtent view_extent(const PointView& view, const Eigen::Matrix3d& axes, BodyEnds ends,
                       const ViewExtentOptions& options) {
  ViewExtent seen;
  const double rim_m = ends == BodyEnds::round ? 0 : view.rim_m;
  seen.horizon_rad = ends == BodyEnds::round ? view.horizon_rad : std::numbers::pi / 2;
  const Eigen::Vector3d to_body =
      (view.body_from_camera.rotation * view.points->rowwise().mean()).normalized();
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d axis = axes.col(k);
    const Eigen::Vector3d in_camera = view.body_from_camera.rotation.conjugate() * axis;
    const double camera = axis.dot(view.body_from_camera.translation);
    const double away = axis.dot(to_body);
    seen.high_m[k] = camera + mean_of_furthest(*view.points, in_camera, options.top_share) +
                     rim_weight(-away, options) * rim_m;
    seen.low_m[k] = camera - mean_of_furthest(*view.points, -in_camera, options.top_share) -
                    rim_weight(away, options) * rim_m;
    seen.away[k] = away;
  }
  return seen;
}

// Of an ellipsoid's extent along an axis at this cosine to the line of sight, the share up to its horizon, as
// on a ball.
double shown_share(double away, double horizon_rad) {
  const double tilt = std::acos(std::min(1.0, std::abs(away)));
  const double near_end = tilt < horizon_rad ? 1 : std::cos(tilt - horizon_rad);
  return (near_end - std::cos(tilt + horizon_rad)) / 2;
}

}  // namespace

std::vector<ViewExtent> view_extents(const std::vector<PointView>& views, const Eigen::Matrix3d& axes,
                                     BodyEnds ends, const ViewExtentOptions& options) {
  std::vector<ViewExtent> whole, cut;
  for (const PointView& view : views)
    if (view.points->cols() >= kLeastPoints)
      (view.cut.empty() ? whole : cut).push_back(view_extent(view, axes, ends, options));
  return whole.empty() ? cut : whole;
}

std::optional<AxisEstimate> fuse_extents(const std::vector<ViewExtent>& views, double least_m, BodyEnds ends,
                                         const AxisFusionOptions& fusion, const ViewExtentOptions& options) {
  if (views.empty()) return std::nullopt;
  std::vector<AxisEstimate> samples(views.size());
  Eigen::Array3d missed_m;
  for (int k = 0; k < 3; ++k) {
    std::vector<double> halves, hidden;
    for (const ViewExtent& seen : views) halves.push_back((seen.high_m[k] - seen.low_m[k]) / 2);
    const double scale = std::max(quantile(halves, options.scale_quantile), least_m);
    for (std::size_t i = 0; i < views.size(); ++i) {
      const double hides = 1 - shown_share(views[i].away[k], views[i].horizon_rad);
      const bool round = ends == BodyEnds::round;
      hidden.push_back((round ? kRoundDoubt : 1) * scale * hides);
      samples[i].semi_axes_m[k] = round ? halves[i] / (1 - hides) : halves[i];
      samples[i].sigma_m[k] = std::hypot(options.noise_m, hidden[i]);
    }
    double weight = 0, missed = 0;
    for (std::size_t i = 0; i < views.size(); ++i) {
      const double trust = 1 / (samples[i].sigma_m[k] * samples[i].sigma_m[k]);
      weight += trust;
      missed += trust * hidden[i];
    }
    missed_m[k] = missed / weight;
  }
  AxisFusionOptions weighted = fusion;
  weighted.weighted_spread = true;
  auto fused = fuse_axes(samples, weighted);
  if (!fused || !(fused->semi_axes_m.minCoeff() > 0)) return std::nullopt;
  fused->sigma_m = (fused->sigma_m.array().square() + missed_m.square() +
                    (options.model * fused->semi_axes_m.array()).square())
                       .sqrt();
  return fused;
}

Eigen::Vector3d center_of_extents(const std::vector<ViewExtent>& views, const Eigen::Vector3d& semi_axes_m,
                                  const ViewExtentOptions& options) {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  if (views.empty()) return center;
  for (int k = 0; k < 3; ++k) {
    std::vector<double> centers;
    for (const ViewExtent& seen : views) {
      const double half = (seen.high_m[k] - seen.low_m[k]) / 2;
      const double far = std::clamp(seen.away[k] / options.near_cosine, -1.0, 1.0);
      centers.push_back((seen.high_m[k] + seen.low_m[k]) / 2 + far * (semi_axes_m[k] - half));
    }
    center[k] = quantile(centers, 0.5);
  }
  return center;
}

}  // namespace uniquadric
