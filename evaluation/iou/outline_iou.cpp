#include "evaluation/iou/outline_iou.h"

#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <clipper.hpp>
#include <cmath>
#include <numbers>

#include "evaluation/iou/disc_ellipse.h"

namespace uniquadric {
namespace {

using Corners = std::array<Eigen::Vector2d, 4>;
constexpr double kClipperRange = 0x3FFFFFFF;  // beyond it Clipper turns to slow 128-bit products

std::array<double, 5> numbers_of(const Ellipse& e) {
  return {e.semi_major * e.semi_minor, e.semi_major, e.angle_rad, e.center.x(), e.center.y()};
}

Eigen::Matrix2d axes(const Ellipse& e) {
  const double c = std::cos(e.angle_rad), s = std::sin(e.angle_rad);
  Eigen::Matrix2d R;
  R << c, -s, s, c;
  return R;
}

Corners rectangle(const Ellipse& e) {
  const Eigen::Matrix2d R = axes(e);
  const Eigen::Vector2d u = R.col(0) * e.semi_major, v = R.col(1) * e.semi_minor;
  return {e.center - u - v, e.center + u - v, e.center + u + v, e.center - u + v};
}

Corners image_outline(const Camera& camera) {
  const double right = camera.width - 0.5, bottom = camera.height - 0.5;
  return {Eigen::Vector2d(-0.5, -0.5), {right, -0.5}, {right, bottom}, {-0.5, bottom}};
}

// Maps pixels to Clipper's integers so that all given corners fit.
class IntegerFrame {
 public:
  explicit IntegerFrame(const std::vector<Corners>& polygons) {
    Eigen::Vector2d low = polygons.front().front(), high = low;
    for (const Corners& polygon : polygons)
      for (const Eigen::Vector2d& corner : polygon) {
        low = low.cwiseMin(corner);
        high = high.cwiseMax(corner);
      }
    center_ = (low + high) / 2;
    scale_ = kClipperRange / ((high - low).maxCoeff() / 2);
  }
  ClipperLib::Paths path(const Corners& polygon) const {
    ClipperLib::Path path;
    for (const Eigen::Vector2d& corner : polygon) {
      const Eigen::Vector2d p = (corner - center_) * scale_;
      path.emplace_back(std::llround(p.x()), std::llround(p.y()));
    }
    return {path};
  }

 private:
  Eigen::Vector2d center_;
  double scale_ = 1;
};

ClipperLib::Paths intersection(const ClipperLib::Paths& a, const ClipperLib::Paths& b) {
  ClipperLib::Clipper clipper;
  clipper.AddPaths(a, ClipperLib::ptSubject, true);
  clipper.AddPaths(b, ClipperLib::ptClip, true);
  ClipperLib::Paths result;
  clipper.Execute(ClipperLib::ctIntersection, result, ClipperLib::pftNonZero, ClipperLib::pftNonZero);
  return result;
}

double area(const ClipperLib::Paths& paths) {
  double sum = 0;
  for (const auto& path : paths) sum += ClipperLib::Area(path);
  return std::abs(sum);
}

// Nothing when both are empty.
std::optional<double> polygon_iou(const ClipperLib::Paths& a, const ClipperLib::Paths& b) {
  const double common =
      a == b ? area(a) : area(intersection(a, b));  // the clipper may begin at another corner
  const double all = area(a) + area(b) - common;
  if (!(all > 0)) return std::nullopt;
  return std::clamp(common / all, 0.0, 1.0);
}

}  // namespace

double ellipse_iou(const Ellipse& a, const Ellipse& b) {
  if (numbers_of(a) == numbers_of(b)) return 1;
  const bool swap = numbers_of(a) < numbers_of(b);
  const Ellipse& disc = swap ? b : a;  // whitened to the unit disc: the larger one
  const Ellipse& other = swap ? a : b;
  const Eigen::Vector2d radii(disc.semi_major, disc.semi_minor);
  const Eigen::Matrix2d to_disc = axes(disc).transpose();
  const Eigen::Matrix2d shape = radii.cwiseInverse().asDiagonal() * (to_disc * axes(other)) *
                                Eigen::Vector2d(other.semi_major, other.semi_minor).asDiagonal();
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(shape, Eigen::ComputeFullU);
  const Eigen::Vector2d center =
      svd.matrixU().transpose() * (to_disc * (other.center - disc.center)).cwiseQuotient(radii);
  const double common = intersect_unit_disc(center, svd.singularValues()).area / std::numbers::pi;
  return std::clamp(common / (1 + svd.singularValues().prod() - common), 0.0, 1.0);
}

double rotated_rectangle_iou(const Ellipse& a, const Ellipse& b) {
  if (numbers_of(a) == numbers_of(b)) return 1;
  const bool swap = numbers_of(b) < numbers_of(a);
  const Corners p = rectangle(swap ? b : a), q = rectangle(swap ? a : b);
  const IntegerFrame frame({p, q});
  return polygon_iou(frame.path(p), frame.path(q)).value_or(0);
}

double axis_aligned_box_iou(const Ellipse& a, const Ellipse& b) {
  const Eigen::Vector2d ha = half_extents(a), hb = half_extents(b);
  const Eigen::Array2d between = b.center - a.center;  // about a's centre: no digits lost far from the origin
  const Eigen::Array2d low = (-ha.array()).max(between - hb.array());
  const Eigen::Array2d high = ha.array().min(between + hb.array());
  const double common = (high - low).max(0.0).prod();
  return std::clamp(common / (4 * ha.prod() + 4 * hb.prod() - common), 0.0, 1.0);
}

std::optional<double> clipped_rectangle_iou(const Ellipse& a, const Ellipse& b, const Camera& camera) {
  const bool swap = numbers_of(b) < numbers_of(a);
  const Corners p = rectangle(swap ? b : a), q = rectangle(swap ? a : b);
  const Corners image = image_outline(camera);
  const IntegerFrame frame({p, q, image});
  const ClipperLib::Paths outline = frame.path(image);
  return polygon_iou(intersection(frame.path(p), outline), intersection(frame.path(q), outline));
}

Eigen::Vector2d half_extents(const Ellipse& ellipse) {
  return ellipse_covariance(ellipse).diagonal().cwiseSqrt();
}

}  // namespace uniquadric
