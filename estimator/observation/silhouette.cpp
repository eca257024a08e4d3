#include "estimator/observation/silhouette.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "estimator/observation/outline.h"
#include "estimator/observation/outline_cuts.h"

namespace uniquadric {
namespace {

Eigen::Vector2d direction(double angle_rad) {
  return {std::cos(angle_rad), std::sin(angle_rad)};
}

// The body's outline and what is needed to measure tangents to it.
struct Outline {
  std::vector<OutlinePoint> points;
  std::vector<Eigen::Vector2d> hull;
  OutlineSurroundings surroundings;
  const SilhouetteOptions& options;
};

// Whether few enough of the outline points that a line touches are cut.
bool is_free(const Outline& outline, const Eigen::Vector2d& normal, double offset_px) {
  int touched = 0, cut = 0;
  for (const OutlinePoint& point : outline.points) {
    if (normal.dot(point.pixel) < offset_px - outline.options.touch_px) continue;
    ++touched;
    cut += is_cut(outline.surroundings, point.image, normal, outline.options);
  }
  return cut <= outline.options.cut_share * touched;
}

// Length of the hull beside its tangent, weighted by exp(-gap / scale): in closed form for each edge, along
// which the gap grows evenly.
double touching_length(const std::vector<Eigen::Vector2d>& hull, const Eigen::Vector2d& normal,
                       double offset_px, double scale_px) {
  double length = 0;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Eigen::Vector2d &a = hull[i], &b = hull[(i + 1) % hull.size()];
    const double gap_a = (offset_px - normal.dot(a)) / scale_px,
                 gap_b = (offset_px - normal.dot(b)) / scale_px;
    const double change = gap_b - gap_a;
    const double weight =
        std::abs(change) < 1e-6 ? std::exp(-gap_a) : (std::exp(-gap_a) - std::exp(-gap_b)) / change;
    length += weight * (b - a).norm();
  }
  return length;
}

// By how much the noise of an outline is expected to push a tangent outwards.
double noise_bias(const Outline& outline, const Eigen::Vector2d& normal, double offset_px) {
  constexpr double kGrowth = 0.75, kDecay = 1.5;  // fitted to drawn shapes, see the header
  const double sigma = outline.options.outline_noise_px;
  if (!(sigma > 0)) return 0;
  const double length = touching_length(outline.hull, normal, offset_px, sigma / kDecay);
  return kGrowth * sigma * std::log1p(length / outline.options.outline_length_px);
}

SupportLine tangent(const Outline& outline, const Eigen::Vector2d& normal) {
  const double offset_px = support_offset(outline.hull, normal);
  return {normal, offset_px - noise_bias(outline, normal, offset_px), is_free(outline, normal, offset_px)};
}

// Fills the rectangle from tangents at right angles, the first `angle_rad` from the x axis.
void set_rectangle(Silhouette& silhouette, const Outline& outline, double angle_rad) {
  std::array<SupportLine, 4> sides;  // +x, -x, +y, -y of the rectangle's own axes
  for (int i = 0; i < 4; ++i)
    sides[i] = tangent(outline, (i % 2 ? -1.0 : 1.0) * direction(angle_rad + (i / 2) * std::numbers::pi / 2));
  double half_x = (sides[0].offset_px + sides[1].offset_px) / 2;
  double half_y = (sides[2].offset_px + sides[3].offset_px) / 2;
  silhouette.rot_bbox.center =
      (sides[0].offset_px - half_x) * sides[0].normal + (sides[2].offset_px - half_y) * sides[2].normal;
  if (half_x < half_y) {  // turned by a quarter the new +minor is the old -x
    std::swap(half_x, half_y);
    sides = {sides[2], sides[3], sides[1], sides[0]};
    angle_rad += std::numbers::pi / 2;
  }
  silhouette.rot_bbox.semi_major = half_x;
  silhouette.rot_bbox.semi_minor = half_y;
  silhouette.rot_bbox.angle_rad = angle_rad;
  for (int i = 0; i < 4; ++i) silhouette.side_free[i] = sides[i].free;
}

Silhouette silhouette_of(const Outline& outline, int area_px) {
  Silhouette silhouette;
  set_rectangle(silhouette, outline, least_rectangle_angle(outline.hull));
  for (int k = 0; k < outline.options.directions; ++k)
    silhouette.support.push_back(
        tangent(outline, direction(2 * std::numbers::pi * k / outline.options.directions)));
  silhouette.bbox = {tangent(outline, {1, 0}), tangent(outline, {0, 1}), tangent(outline, {-1, 0}),
                     tangent(outline, {0, -1})};
  silhouette.area_px = area_px;
  return silhouette;
}

}  // namespace

std::map<int, Silhouette> silhouettes(const cv::Mat& masks, const cv::Mat& depth, const Camera& camera,
                                      const SilhouetteOptions& options) {
  std::map<int, Silhouette> result;
  for (const auto& [id, region] : mask_regions(masks, options.min_pixels, options.min_share)) {
    Outline outline{outline_points(region, camera), {}, {masks, depth, id}, options};
    std::vector<Eigen::Vector2d> pixels;
    for (const auto& point : outline.points) pixels.push_back(point.pixel);
    outline.hull = convex_hull(std::move(pixels));
    if (outline.hull.size() >= 3) result.emplace(id, silhouette_of(outline, region.area_px));
  }
  return result;
}

}  // namespace uniquadric
