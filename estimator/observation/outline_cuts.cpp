#include "estimator/observation/outline_cuts.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "core/base/quantile.h"

namespace uniquadric {
namespace {

constexpr int kMinNearer = 2;  // one nearer pixel may be a wrong measurement
// From the normal [rad]: where the edge of a body in front crosses the outline, this one goes on behind it to
// the side. Of what has no id the ground is nearer there, too.
constexpr std::array<double, 4> kSideways{-std::numbers::pi / 4, std::numbers::pi / 4, -std::numbers::pi / 2,
                                          std::numbers::pi / 2};
constexpr double kBodyJump =
    1.0 / 3;  // share of occluder_jump that tells another body, which no slope feigns

bool is_at_border(const cv::Mat& image, const Eigen::Vector2d& pixel, double border_px) {
  return pixel.x() < border_px - 0.5 || pixel.y() < border_px - 0.5 ||
         pixel.x() > image.cols - 0.5 - border_px || pixel.y() > image.rows - 0.5 - border_px;
}

std::optional<cv::Point> pixel_at(const cv::Mat& image, const Eigen::Vector2d& position) {
  const cv::Point p(static_cast<int>(std::lround(position.x())), static_cast<int>(std::lround(position.y())));
  if (p.x < 0 || p.y < 0 || p.x >= image.cols || p.y >= image.rows) return std::nullopt;
  return p;
}

double depth_at(const cv::Mat& depth, const cv::Point& p) {
  return depth.empty() ? 0 : depth.at<float>(p);
}

void add_own_depth(const OutlineSurroundings& around, const Eigen::Vector2d& position,
                   std::vector<double>& depths) {
  const auto p = pixel_at(around.masks, position);
  if (!p || around.masks.at<std::uint16_t>(*p) != around.id) return;
  if (const double z = depth_at(around.depth, *p); z > 0) depths.push_back(z);
}

double median_or_zero(std::vector<double> depths) {
  return depths.empty() ? 0 : upper_median(std::move(depths));
}

// Median depth of the body along a line into it; 0 where nothing is measured. The outermost pixels may be
// another's: masks are pixels off.
double depth_inside(const OutlineSurroundings& around, const Eigen::Vector2d& pixel,
                    const Eigen::Vector2d& normal, int reach_px) {
  std::vector<double> depths;
  for (int k = 2; k <= 2 + reach_px; ++k) add_own_depth(around, pixel - k * normal, depths);
  return median_or_zero(std::move(depths));
}

// The same all about a pixel. Some of its mask may be another's.
double depth_about(const OutlineSurroundings& around, const Eigen::Vector2d& pixel, int reach_px) {
  std::vector<double> depths;
  for (int dv = -reach_px; dv <= reach_px; ++dv)
    for (int du = -reach_px; du <= reach_px; ++du)
      add_own_depth(around, pixel + Eigen::Vector2d(du, dv), depths);
  return median_or_zero(std::move(depths));
}

// What lies beside the outline at `pixel`, along `outward`, against the body's depth there.
struct Beside {
  int nearer = 0, nearer_bodies = 0;
  int unknown = 0, farther = 0;  // of other bodies
};

Beside look_beside(const OutlineSurroundings& around, const Eigen::Vector2d& pixel,
                   const Eigen::Vector2d& outward, double inside_m, const SilhouetteOptions& options) {
  Beside beside;
  for (int k = 1; k <= options.occluder_reach_px; ++k) {
    const auto p = pixel_at(around.masks, pixel + k * outward);
    if (!p) break;
    const int id = around.masks.at<std::uint16_t>(*p);
    const double z = depth_at(around.depth, *p);
    if (id == around.id) continue;
    const double jump = (id == 0 ? 1 : kBodyJump) * options.occluder_jump;
    const bool is_nearer = z > 0 && inside_m > 0 && z < (1 - jump) * inside_m;
    beside.nearer += is_nearer;
    if (id == 0) continue;
    beside.nearer_bodies += is_nearer;
    if (!(z > 0 && inside_m > 0)) ++beside.unknown;
    if (z > inside_m && inside_m > 0) ++beside.farther;
  }
  return beside;
}

bool meets_a_body(const OutlineSurroundings& around, const Eigen::Vector2d& pixel,
                  const Eigen::Vector2d& outward, int reach_px) {
  for (int k = 1; k <= reach_px; ++k) {
    const auto p = pixel_at(around.masks, pixel + k * outward);
    if (!p) break;
    if (const int id = around.masks.at<std::uint16_t>(*p); id != 0 && id != around.id) return true;
  }
  return false;
}

}  // namespace

bool is_cut(const OutlineSurroundings& around, const Eigen::Vector2d& pixel, const Eigen::Vector2d& normal,
            const SilhouetteOptions& options) {
  if (is_at_border(around.masks, pixel, options.border_px)) return true;
  const int reach_px = options.occluder_reach_px;
  const double inside_m = depth_inside(around, pixel, normal, reach_px);
  const Beside front = look_beside(around, pixel, normal, inside_m, options);
  if (front.nearer >= kMinNearer || (front.unknown >= kMinNearer && front.farther == 0 && front.nearer == 0))
    return true;
  std::optional<double> about_m;  // most outlines have no other body beside them
  return std::any_of(kSideways.begin(), kSideways.end(), [&](double angle_rad) {
    const Eigen::Vector2d outward = Eigen::Rotation2Dd(angle_rad) * normal;
    if (!meets_a_body(around, pixel, outward, reach_px)) return false;
    if (!about_m) about_m = depth_about(around, pixel, reach_px);
    return look_beside(around, pixel, outward, *about_m, options).nearer_bodies >= kMinNearer;
  });
}

}  // namespace uniquadric
