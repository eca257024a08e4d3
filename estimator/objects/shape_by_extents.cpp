#include "estimator/objects/shape_by_extents.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/base/quantile.h"
#include "estimator/objects/seen_extents.h"
#include "estimator/shape/oriented_box.h"
#include "estimator/shape/usual_orientation.h"
#include "estimator/shape/view_extents.h"

namespace uniquadric {
namespace {

// All ours.
constexpr double kTurnSigma =
    0.3;  // [rad] of the axes before: boxes that agree count, whatever was found last
constexpr double kAgreeing = 0.025;       // [rad] of what boxes leave open, below which there is no doubt
constexpr double kFreeCenterSigma = 0.1;  // [m] of an ellipsoid that the outlines are to tell
constexpr double kFreeTurnSigma = 0.1;    // [rad] of the same
constexpr double kRoundGain = 3;          // of log-likelihood: twenty times as likely
constexpr double kCenterSigma = 0.004;    // [m] of the centre that extents give
constexpr double kLeastOff = 0.001;       // [m] of points from a surface: less is no better a fit
constexpr Eigen::Index kFewPoints = 30;
constexpr int kNoiseRounds =
    2;  // of the outlines' noise, each with the last one's shape; a third changes little

// How far the outline lies beyond the points [px], by the sides of the RotBbox. The least of them tells of
// the straight parts: one side lies along an edge of a body that has edges, others touch a corner, where
// points end well before.
struct Rim {
  double least_px = 0;
  double horizon_rad =
      std::numbers::pi / 2;  // of an ellipsoid whose points end by their mean before the outline
};

Rim rim_of(const Camera& camera, const ShapeView& view) {
  if (view.points.cols() < kFewPoints) return {};
  Eigen::Matrix3Xd pixels(3, view.points.cols());
  for (Eigen::Index i = 0; i < pixels.cols(); ++i)
    pixels.col(i) << (camera.matrix() * view.points.col(i)).hnormalized(), 0;
  std::vector<double> beyond_px;
  for (const SupportLine& side : sides_of(view.silhouette)) {
    if (!side.free) continue;
    const Eigen::Vector3d normal(side.normal.x(), side.normal.y(), 0);
    beyond_px.push_back(side.offset_px - mean_of_furthest(pixels, normal, ViewExtentOptions{}.top_share));
  }
  if (beyond_px.empty()) return {};
  const double mean_px =
      std::accumulate(beyond_px.begin(), beyond_px.end(), 0.0) / static_cast<double>(beyond_px.size());
  const Ellipse& box = view.silhouette.rot_bbox;
  const double inner = 1 - mean_px / std::sqrt(box.semi_major * box.semi_minor);
  return {*std::min_element(beyond_px.begin(), beyond_px.end()), std::asin(std::clamp(inner, 0.5, 1.0))};
}

double m_per_px(const ExtentEvidence& evidence, const ShapeView& view) {
  return view.points.cols() > 0 ? view.points.row(2).mean() / evidence.camera.fx : 0;
}

std::vector<PointView> point_views(const ExtentEvidence& evidence) {
  std::vector<PointView> views;
  for (const ShapeView& view : evidence.views) {
    const Rim rim = rim_of(evidence.camera, view);
    PointView& seen = views.emplace_back(point_view(evidence.camera, view));
    seen.rim_m = m_per_px(evidence, view) * rim.least_px;
    seen.horizon_rad = rim.horizon_rad;
  }
  return views;
}

// Of an ellipsoid's surface at the origin, to first order.
double distance_to_ellipsoid(const Eigen::Vector3d& semi_axes_m, const Eigen::Vector3d& p) {
  const Eigen::Vector3d unit = p.cwiseQuotient(semi_axes_m);
  const double gauge = unit.norm();
  if (gauge == 0) return semi_axes_m.minCoeff();
  return std::abs(gauge - 1) * gauge / unit.cwiseQuotient(semi_axes_m).norm();
}

// How far the points lie off the body's surface: off its box, or off its ellipsoid.
double median_off_m(const std::vector<PointView>& views, const Shape& shape, BodyEnds ends) {
  const Pose object_from_body = shape.body_from_object.inverse();
  const OrientedBox box{Eigen::Vector3d::Zero(), Eigen::Matrix3d::Identity(), shape.semi_axes_m};
  std::vector<double> off_m;
  for (const PointView& view : views) {
    const Pose object_from_camera = object_from_body * view.body_from_camera;
    for (const auto& in_camera : view.points->colwise()) {
      const Eigen::Vector3d p = object_from_camera * in_camera;
      off_m.push_back(ends == BodyEnds::edges ? distance_to_surface(box, p)
                                              : distance_to_ellipsoid(shape.semi_axes_m, p));
    }
  }
  return quantile(std::move(off_m), 0.5);
}

// A weak belief in axes as long as half the outlines are across: nothing else tells what lies along the lines
// of sight. Where there are views, some have points.
AxisBelief thin_belief(const ExtentEvidence& evidence) {
  std::vector<double> across_m;
  for (const ShapeView& view : evidence.views)
    if (view.points.cols() > 0)
      across_m.push_back(view.silhouette.rot_bbox.semi_minor * m_per_px(evidence, view));
  const Eigen::Vector3d thin = Eigen::Vector3d::Constant(quantile(std::move(across_m), 0.5));
  return {thin, evidence.thin_sigma * thin};
}

struct Fit {
  Shape shape;
  double cost = 0;  // minus the logarithm of its likelihood, the noise being what is seen about it
};

// Axes and centre by the extents of single views along the axes of `from` (Alg. 2, Eq. 15), outlines with the
// noise that they turn out to have: first about those axes (an ellipsoid's: as `from` has them), then about
// what was found.
std::optional<Fit> fit_extents(const ExtentEvidence& evidence, const std::vector<PointView>& views,
                               Shape from, BodyEnds ends) {
  const Eigen::Quaterniond rotation = from.body_from_object.rotation;
  const Eigen::Matrix3d axes = rotation.toRotationMatrix();
  const std::vector<ViewExtent> seen = view_extents(views, axes, ends);
  const auto extents = fuse_extents(seen, evidence.least_m, ends, evidence.fusion);
  if (!extents) return std::nullopt;
  const std::vector<AxisBelief> beliefs = {thin_belief(evidence), {extents->semi_axes_m, extents->sigma_m}};
  LongWindowOptions options = evidence.long_window;
  const double given_px = options.outline_sigma_px;
  options.offset_sigmas = options.covariance_offset_sigmas = {kCenterSigma, kHeldTurn};
  const auto sigma_px = [&](const Shape& shape) {
    if (options.outline_noise == OutlineNoise::given) return given_px;
    return std::max(given_px,
                    outline_misfit_px(evidence.camera, evidence.views, shape, options).value_or(given_px));
  };
  if (ends == BodyEnds::edges) from.semi_axes_m = extents->semi_axes_m;
  for (int round = 0; round < kNoiseRounds; ++round) {
    from.body_from_object.translation = axes * center_of_extents(seen, from.semi_axes_m);
    options.outline_sigma_px = sigma_px(from);
    from = solve_shape(evidence.camera, evidence.views, {}, beliefs, from, options).shape;
  }
  from.body_from_object.rotation = rotation;
  const Eigen::Vector3d off = (from.semi_axes_m - extents->semi_axes_m).cwiseQuotient(extents->sigma_m);
  const double off_m = std::max(kLeastOff, median_off_m(views, from, ends));
  return Fit{from, 5 * std::log(sigma_px(from) * off_m) + off.squaredNorm() / 2};
}

// What the outlines alone make of the body, if it is an ellipsoid: its axes stay where turning them gains
// nothing.
Shape ellipsoid_of_outlines(const ExtentEvidence& evidence, const Shape& start) {
  LongWindowOptions options = evidence.long_window;
  options.offset_sigmas = {kFreeCenterSigma, kFreeTurnSigma};
  const ShapeSolution free =
      solve_shape(evidence.camera, evidence.views, {}, {thin_belief(evidence)}, start, options);
  options.offset_sigmas.rotation_rad = kHeldTurn;
  const ShapeSolution held =
      solve_shape(evidence.camera, evidence.views, {}, {thin_belief(evidence)}, start, options);
  return held.cost < free.cost + kTurnGain ? held.shape : free.shape;
}

}  // namespace

std::optional<Shape> shape_by_extents(const ExtentEvidence& evidence, const Shape& before) {
  std::deque<Eigen::Quaterniond> boxes;
  for (const Pose& box : evidence.boxes) boxes.push_back(box.rotation);
  const auto usual = usual_orientation(boxes);
  if (!usual) return std::nullopt;
  const UsualOrientation turned = updated_orientation(before.body_from_object.rotation, kTurnSigma, *usual);
  const std::vector<PointView> views = point_views(evidence);
  Shape start = before;
  start.body_from_object.rotation = turned.rotation;
  auto edged = fit_extents(evidence, views, start, BodyEnds::edges);
  if (!edged) return std::nullopt;
  edged->shape.variances.tail<3>() = turned.sigma_rad.cwiseAbs2();
  if (evidence.long_window.outline_noise == OutlineNoise::given || turned.sigma_rad.maxCoeff() < kAgreeing)
    return edged->shape;
  start = edged->shape;
  start.body_from_object.rotation = before.body_from_object.rotation;
  const Shape ellipsoid = ellipsoid_of_outlines(evidence, start);
  auto round = fit_extents(evidence, views, ellipsoid, BodyEnds::round);
  if (!round || round->cost + kRoundGain > edged->cost) return edged->shape;
  round->shape.variances.tail<3>() = ellipsoid.variances.tail<3>();
  return round->shape;
}

}  // namespace uniquadric
