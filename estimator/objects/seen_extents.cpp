#include "estimator/objects/seen_extents.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "estimator/objects/outline_reach.h"

namespace uniquadric {
namespace {

// All ours.
constexpr double kBeyond = 1.5, kBeyondRadii = 1;  // of the solved end, where no point of the body lies
constexpr double kShortPx = 8;                     // by which points end inside the outline at most,
constexpr double kShort = 0.2;                     // or of its half width,
constexpr double kShortSpacings = 3;               // or between points: a LiDAR's are far apart
constexpr double kBestViews = 0.5;                 // quantile of the views that show most of a side
constexpr double kRimSpacings = 0.75;              // between points, that they end inside the outline at most
constexpr double kLeastRim =
    0.8;  // share of a semi-axis that an ellipsoid would show: below, points say little
constexpr double kAgreeing = 0.03;      // radii, within which points and a fit agree: the fit has all of them
constexpr double kMostAgreeing = 0.01;  // [m] of the same: what a pose or a cell is off by does not grow
constexpr double kEndSigma = 0.003;     // [m] of an end read off points, at best
constexpr double kCutSigma = 1;         // radii, of an end that was cut from every view
constexpr double kUnseenSigma = 0.05;   // radii, of an end that no camera saw

// Mean distance of a view's points to their neighbours.
double point_spacing(const Shape& shape, const std::vector<PointView>& views) {
  double count = 1;
  for (const PointView& view : views) count += static_cast<double>(view.points->cols());
  const double radius = std::cbrt(shape.semi_axes_m.prod());
  return radius * std::sqrt(2 * std::numbers::pi * static_cast<double>(views.size()) / count);
}

// How far an ellipsoid's visible part reaches along an axis, as a share of the semi-axis, in the views that
// show most of it. A body with more of a box is seen up to its end.
double visible_share(const Shape& shape, const std::vector<PointView>& views, int axis, int sign) {
  std::vector<double> shares;
  for (const PointView& view : views) {
    if (!view.cut.empty()) continue;
    const Eigen::Vector3d camera = shape.body_from_object.inverse() * view.body_from_camera.translation;
    const Eigen::Vector3d normal = camera.cwiseQuotient(shape.semi_axes_m).normalized();
    const double away = std::min(0.0, sign * normal[axis]);
    shares.push_back(std::sqrt(std::max(0.0, 1 - away * away)));
  }
  if (shares.empty()) return 0;
  const auto at =
      shares.begin() + static_cast<std::ptrdiff_t>(kBestViews * static_cast<double>(shares.size() - 1));
  std::nth_element(shares.begin(), at, shares.end());
  return *at;
}

// Whether the points end far inside the outline along a line's normal.
bool ends_short(const Eigen::Matrix2Xd& pixels, const SupportLine& line, double inside_px) {
  return (line.normal.transpose() * pixels).maxCoeff() < line.offset_px - inside_px;
}

// `about`: what is known of where the body ends in the other axes, without which an outline says little.
Shape with_ends(Shape shape, const Shape& about, const std::vector<PointView>& views, double radius_m) {
  const double spacing = point_spacing(shape, views);
  const auto fused = [&](double solved, double seen) {
    const double doubts = (seen - solved) / std::min(kAgreeing * radius_m, kMostAgreeing);
    return seen + (solved - seen) / (1 + std::pow(doubts, 4));
  };
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    std::array<double, 2> ends{}, sigmas{};
    for (int side = 0; side < 2; ++side) {
      const Eigen::Vector3d direction =
          (side ? -1 : 1) * (shape.body_from_object.rotation * Eigen::Vector3d::Unit(axis));
      const double center = direction.dot(shape.body_from_object.translation);
      ends[side] = shape.semi_axes_m[axis];
      sigmas[side] = kUnseenSigma * radius_m;
      const auto reach = reach_along(views, direction);
      if (!reach) continue;
      double end = reach->position_m - center;
      if (end > kBeyond * shape.semi_axes_m[axis] + kBeyondRadii * radius_m) {  // strays, in most views
        sigmas[side] = end - shape.semi_axes_m[axis];
        continue;
      }
      // few points may lie on a thin end (wheels, an egg's tip), and a mask's rim has none
      auto outlined = reach_by_outlines(about, views, axis, side ? -1 : 1);
      if (outlined) *outlined += direction.dot(about.body_from_object.translation) - center;
      if (reach->views > 0) {
        end = std::max(end, std::min(ends[side], outlined.value_or(end)));
        sigmas[side] = std::max(kEndSigma, std::abs(end - ends[side]));  // of two ways to tell
        ends[side] = fused(ends[side], end);
      } else if (end > ends[side]) {
        ends[side] = fused(ends[side], end);
      } else if (const double seen_share = visible_share(shape, views, axis, side ? -1 : 1); seen_share > 0) {
        const double by_points = std::max(end, (end + kRimSpacings * spacing) / seen_share);
        sigmas[side] = std::max(sigmas[side], ends[side] - by_points);  // a fit that is far off tells little
        if (seen_share > kLeastRim)
          ends[side] = std::min(ends[side], std::max(by_points, outlined.value_or(by_points)));
      }
      if (reach->is_cut) sigmas[side] = kCutSigma * radius_m;
    }
    if (!(ends[0] + ends[1] > 0)) continue;
    for (double* variance : {&shape.variances[axis], &shape.variances[3 + axis]})
      *variance = std::max(*variance, (sigmas[0] * sigmas[0] + sigmas[1] * sigmas[1]) / 4);
    shape.semi_axes_m[axis] = (ends[0] + ends[1]) / 2;
    shift[axis] = (ends[0] - ends[1]) / 2;
  }
  shape.body_from_object.translation += shape.body_from_object.rotation * shift;
  return shape;
}

}  // namespace

PointView point_view(const Camera& camera, const ShapeView& view) {
  PointView seen;
  seen.touches = outline_touches(camera, view.silhouette);
  seen.body_from_camera = view.world_from_body.inverse() * view.world_from_camera;
  seen.points = &view.points;
  seen.normals = &view.normals;
  const Eigen::Index count = view.points.cols();
  Eigen::Matrix2Xd pixels(2, count);
  for (Eigen::Index i = 0; i < count; ++i)
    pixels.col(i) = (camera.matrix() * view.points.col(i)).hnormalized();
  const Ellipse& box = view.silhouette.rot_bbox;
  const double spacing_px = 2 * std::sqrt(box.semi_major * box.semi_minor / static_cast<double>(count));
  const double inside_px = std::max({kShortPx, kShort * box.semi_minor, kShortSpacings * spacing_px});
  for (const SupportLine& line : view.silhouette.support)
    if (!line.free || (count > 0 && ends_short(pixels, line, inside_px))) seen.cut.push_back(line.normal);
  return seen;
}

Shape with_seen_extents(const Shape& shape, const std::vector<PointView>& views, double radius_m) {
  return with_ends(shape, with_ends(shape, shape, views, radius_m), views, radius_m);
}

}  // namespace uniquadric
