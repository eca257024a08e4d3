#include "estimator/objects/seen_extents.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "core/base/quantile.h"
#include "estimator/objects/outline_reach.h"
#include "estimator/window/contact_sides.h"

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
constexpr double kTipShort = 0.04;     // share by which an ellipse's furthest hundredth is short of it
constexpr int kFewViews = 3;           // of an end, and ends, below which their spread tells no noise
constexpr double kEndSigma = 0.003;    // [m] of an end read off points, at best
constexpr double kCutSigma = 1;        // radii, of an end that was cut from every view
constexpr double kUnseenSigma = 0.05;  // radii, of an end that no camera saw

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

// What points show of one end of an axis, whatever the axes' lengths.
struct Side {
  int axis = 0, sign = 1;
  Eigen::Vector3d direction;  // outward, in the body's frame
  double middle_m = 0;        // of the shape, along it
  std::optional<Reach> reach;
};

std::vector<Side> sides_of(const Shape& shape, const std::vector<PointView>& views) {
  std::vector<Side> sides;
  for (int axis = 0; axis < 3; ++axis)
    for (const int sign : {1, -1}) {
      const Eigen::Vector3d direction =
          sign * (shape.body_from_object.rotation * Eigen::Vector3d::Unit(axis));
      sides.push_back({axis, sign, direction, direction.dot(shape.body_from_object.translation),
                       reach_along(views, direction)});
    }
  return sides;
}

// Of an end read off points: how far views disagree about it, in the median over the ends that are shown.
double noise_of(const std::vector<Side>& sides) {
  std::vector<double> spreads_m;
  for (const Side& side : sides)
    if (side.reach && side.reach->views >= kFewViews) spreads_m.push_back(side.reach->spread_m);
  return spreads_m.size() < kFewViews ? 0 : quantile(std::move(spreads_m), 0.5);
}

// Of a side, from the middle.
struct End {
  double at_m = 0, sigma_m = 0;
};

// The mean of two, each by what it is uncertain by. What has no sigma tells nothing.
double fused(const End& a, const End& b) {
  const double a2 = a.sigma_m * a.sigma_m, b2 = b.sigma_m * b.sigma_m;
  if (!std::isfinite(b2) || !(a2 + b2 > 0)) return a.at_m;
  return (a.at_m * b2 + b.at_m * a2) / (a2 + b2);
}

// Share of a semi-axis by which the mean of the furthest points ends before it: of what a body's profile has
// of an ellipse's. Where it is less than the points are apart, as a LiDAR's, that is allowed for already.
double tip_short(const Shape& shape, const Side& side, double spacing_m) {
  if (spacing_m > kTipShort * shape.semi_axes_m[side.axis]) return 0;
  const SuperExponents& e = shape.exponents;
  const double q = side.axis < 2 ? e.outline : side.sign > 0 ? e.upper : e.lower;
  return kTipShort * std::clamp(q - 1, 0.0, 1.0);
}

// `solved`: by the fit; `outlined_m`: at least, by outlines; `seen_share`: of the semi-axis, by points, which
// are as noisy as `noise_m`.
End end_of(const Side& side, const End& solved, std::optional<double> outlined_m, double seen_share,
           double spacing_m, double noise_m, double radius_m) {
  const double solved_m = solved.at_m;
  const auto with_solved = [&](double seen_m) {
    return fused({seen_m, std::max(noise_m, side.reach->spread_m)}, solved);
  };
  End end{solved_m, kUnseenSigma * radius_m};
  if (!side.reach) return end;
  const double seen_m = side.reach->position_m - side.middle_m;
  if (seen_m > kBeyond * solved_m + kBeyondRadii * radius_m)  // strays, in most views
    return {solved_m, seen_m - solved_m};
  if (side.reach->views > 0) {
    // few points may lie on a thin end (wheels, an egg's tip), and a mask's rim has none
    const double shown_m = std::max(seen_m, std::min(solved_m, outlined_m.value_or(seen_m)));
    end = {with_solved(shown_m), std::max(kEndSigma, std::abs(shown_m - solved_m))};  // of two ways to tell
  } else if (seen_m > solved_m) {
    end.at_m = with_solved(seen_m);
  } else if (seen_share > 0) {
    const double by_points_m = std::max(seen_m, (seen_m + kRimSpacings * spacing_m) / seen_share);
    end.sigma_m = std::max(end.sigma_m, solved_m - by_points_m);  // a fit that is far off tells little
    if (seen_share > kLeastRim)
      end.at_m = with_solved(std::min(solved_m, std::max(by_points_m, outlined_m.value_or(by_points_m))));
  }
  if (side.reach->is_cut) end.sigma_m = kCutSigma * radius_m;
  return end;
}

// `about`: what is known of where the body ends in the other axes, without which an outline says little.
Shape with_ends(Shape shape, const Shape& about, const std::vector<Side>& sides,
                const std::vector<PointView>& views, double radius_m,
                const std::vector<ContactSide>& contacts, Lengths lengths) {
  const double spacing_m = point_spacing(shape, views), noise_m = noise_of(sides);
  const auto end_at = [&](const Side& side) {
    for (const ContactSide& contact : contacts)
      if (contact.direction.dot(side.direction) > kSameSideCosine)
        return End{contact.position_m - contact.direction.dot(shape.body_from_object.translation),
                   contact.sigma_m};
    auto outlined_m = reach_by_outlines(about, views, side.axis, side.sign);
    if (outlined_m) *outlined_m += side.direction.dot(about.body_from_object.translation) - side.middle_m;
    const double seen_share =
        visible_share(about, views, side.axis, side.sign) * (1 - tip_short(shape, side, spacing_m));
    const double variance = shape.variances[side.axis] + shape.variances[3 + side.axis];
    const End solved{shape.semi_axes_m[side.axis], lengths == Lengths::fitted
                                                       ? std::sqrt(variance)
                                                       : std::numeric_limits<double>::infinity()};
    return end_of(side, solved, outlined_m, seen_share, spacing_m, noise_m, radius_m);
  };
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    const End high = end_at(sides[2 * axis]), low = end_at(sides[2 * axis + 1]);
    if (!(high.at_m + low.at_m > 0)) continue;
    for (double* variance : {&shape.variances[axis], &shape.variances[3 + axis]})
      *variance = std::max(lengths == Lengths::fitted ? *variance : 0,
                           (high.sigma_m * high.sigma_m + low.sigma_m * low.sigma_m) / 4);
    shape.semi_axes_m[axis] = (high.at_m + low.at_m) / 2;
    shift[axis] = (high.at_m - low.at_m) / 2;
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
  seen.rays = view.points.colwise().normalized();
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

Shape with_seen_extents(const Shape& shape, const std::vector<PointView>& views, double radius_m,
                        const std::vector<ContactSide>& contacts, Lengths lengths) {
  const std::vector<Side> sides = sides_of(shape, views);
  const Shape about = with_ends(shape, shape, sides, views, radius_m, contacts, lengths);
  return with_ends(shape, about, sides, views, radius_m, contacts, lengths);
}

}  // namespace uniquadric
