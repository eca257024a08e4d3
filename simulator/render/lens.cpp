#include "simulator/render/lens.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <opencv2/imgproc.hpp>

namespace uniquadric {
namespace {

constexpr double kFocal = 2;            // of the ideal camera, in focal lengths of the camera
constexpr double kMostAngle_deg = 85;   // ours: beyond, a plane image grows without bound
constexpr double kMostArea_px = 16e6;   // ours: 430 MB of buffers
constexpr double kMostSide_px = 16384;  // of llvmpipe's render buffers
constexpr int kMargin_px = 3;           // colour reaches one pixel, the test for one surface two
constexpr float kSurfaceStep = 1e-3f;   // ours: of inverse depth; rounding makes 3e-5, a sphere's limb 1e-3

// The rays (x, y) that the pixels see; `fault` says why there are none.
struct View {
  Eigen::AlignedBox2d rays;
  double steepest = 0;  // tangent of the widest angle from the optical axis
  std::optional<std::string> fault;
};

View view_of(const Camera& camera) {
  View view;
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u) {
      const auto ray = camera.unproject({u, v});
      if (!ray) {
        view.fault = fmt::format("pixel ({}, {}) has no ray, for the distortion has no inverse there", u, v);
        return view;
      }
      view.rays.extend(ray->head<2>());
      view.steepest = std::max(view.steepest, ray->head<2>().norm());
    }
  return view;
}

// The pixels that the view takes of an image with kFocal pixels for each of the camera's. In floating point:
// of a view that is too wide there may be more than an int counts.
Eigen::AlignedBox2d ideal_pixels(const Camera& camera, const View& view) {
  const Eigen::Array2d focal = kFocal * Eigen::Array2d(camera.fx, camera.fy),
                       center = kFocal * Eigen::Array2d(camera.cx, camera.cy);
  const Eigen::Array2d low = (focal * view.rays.min().array() + center).floor() - kMargin_px,
                       high = (focal * view.rays.max().array() + center).ceil() + kMargin_px;
  return {low.matrix(), high.matrix()};
}

Eigen::Vector2d size_of(const Eigen::AlignedBox2d& pixels) {
  return pixels.sizes() + Eigen::Vector2d::Ones();
}

// Where the lens does not bend, pixels of the camera fall on pixels of the ideal image: nearest pixels there
// are exact, and further out they err to all sides alike.
Camera ideal_camera(const Camera& camera, const View& view) {
  const Eigen::AlignedBox2d pixels = ideal_pixels(camera, view);
  Camera ideal = without_distortion(camera);
  ideal.width = static_cast<int>(size_of(pixels).x());
  ideal.height = static_cast<int>(size_of(pixels).y());
  ideal.fx *= kFocal;
  ideal.fy *= kFocal;
  ideal.cx = kFocal * camera.cx - pixels.min().x();
  ideal.cy = kFocal * camera.cy - pixels.min().y();
  return ideal;
}

cv::Point nearest(const cv::Point2f& place) {
  return {static_cast<int>(place.x + 0.5f), static_cast<int>(place.y + 0.5f)};  // never negative
}

float inverse(float z_m) {
  return z_m > 0 ? 1 / z_m : std::numeric_limits<float>::quiet_NaN();  // fits no line
}

// Whether the step from `a` to `b` goes on with that before or that after it: else there is a jump between
// them.
bool is_one_surface(float before, float a, float b, float after) {
  const float most = kSurfaceStep * a;
  return std::abs(b - 2 * a + before) <= most || std::abs(after - 2 * b + a) <= most;
}

// Inverse depth at a place between four pixels that lie on one surface.
std::optional<float> interpolated(const cv::Mat& depth_m, const cv::Mat& ids, const cv::Point2f& place) {
  const int u = static_cast<int>(place.x), v = static_cast<int>(place.y);
  const auto *id = ids.ptr<std::uint16_t>(v) + u, *id_below = ids.ptr<std::uint16_t>(v + 1) + u;
  if (id[0] != id[1] || id[0] != id_below[0] || id[0] != id_below[1]) return std::nullopt;
  const auto at = [&](int du, int dv) { return inverse(depth_m.at<float>(v + dv, u + du)); };
  const float a = at(0, 0), b = at(1, 0), c = at(0, 1), d = at(1, 1);
  if (!(std::abs(a - b - c + d) <= kSurfaceStep * a) || !is_one_surface(at(-1, 0), a, b, at(2, 0)) ||
      !is_one_surface(at(-1, 1), c, d, at(2, 1)) || !is_one_surface(at(0, -1), a, c, at(0, 2)) ||
      !is_one_surface(at(1, -1), b, d, at(1, 2)))
    return std::nullopt;
  const float x = place.x - static_cast<float>(u), y = place.y - static_cast<float>(v);
  return (1 - y) * ((1 - x) * a + x * b) + y * ((1 - x) * c + x * d);
}

}  // namespace

std::optional<std::string> lens_fault(const Camera& camera) {
  const View view = view_of(camera);
  if (view.fault) return view.fault;
  const double angle_deg = std::atan(view.steepest) * 180 / std::numbers::pi;
  if (angle_deg > kMostAngle_deg)
    return fmt::format("a pixel looks {:.1f} degrees off the optical axis, at most {} can be drawn",
                       angle_deg, kMostAngle_deg);
  const Eigen::Vector2d size = size_of(ideal_pixels(camera, view));
  if (size.prod() > kMostArea_px || size.maxCoeff() > kMostSide_px)
    return fmt::format("an undistorted image of {}x{} px would have to be drawn, at most {} Mpx can be",
                       size.x(), size.y(), kMostArea_px / 1e6);
  return std::nullopt;
}

Lens make_lens(const Camera& camera) {
  const View view = view_of(camera);
  assert(!view.fault);
  Lens lens{
      ideal_camera(camera, view), cv::Mat(camera.height, camera.width, CV_32FC2), {}, {}, view.steepest};
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector2d place = *lens.ideal.project(*camera.unproject({u, v}));
      lens.places.at<cv::Point2f>(v, u) = {static_cast<float>(place.x()), static_cast<float>(place.y())};
    }
  const cv::Mat between = lens.places - cv::Scalar(0.5, 0.5);
  cv::convertMaps(between, cv::noArray(), lens.cells, lens.shares, CV_16SC2);
  return lens;
}

void see_color(const Lens& lens, const cv::Mat& ideal, cv::Mat& rgba) {
  cv::Mat means;  // its pixel (u, v) stands at (u + 0.5, v + 0.5) of the ideal image
  cv::blur(ideal, means, {2, 2}, {0, 0}, cv::BORDER_REPLICATE);
  cv::remap(means, rgba, lens.cells, lens.shares, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
}

void see_ids(const Lens& lens, const cv::Mat& ideal, cv::Mat& ids) {
  ids.create(lens.places.size(), CV_16UC1);
  for (int v = 0; v < ids.rows; ++v)
    for (int u = 0; u < ids.cols; ++u)
      ids.at<std::uint16_t>(v, u) = ideal.at<std::uint16_t>(nearest(lens.places.at<cv::Point2f>(v, u)));
}

cv::Mat see_bits(const Lens& lens, const cv::Mat& ideal, const cv::Rect& part) {
  cv::Mat bits = cv::Mat::zeros(lens.places.size(), CV_8UC1);
  for (int v = 0; v < bits.rows; ++v)
    for (int u = 0; u < bits.cols; ++u)
      if (const cv::Point place = nearest(lens.places.at<cv::Point2f>(v, u)); part.contains(place))
        bits.at<std::uint8_t>(v, u) = ideal.at<std::uint8_t>(place - part.tl());
  return bits;
}

void see_depth(const Lens& lens, const cv::Mat& ideal_m, const cv::Mat& ideal_ids, cv::Mat& depth_m) {
  depth_m.create(lens.places.size(), CV_32FC1);
  for (int v = 0; v < depth_m.rows; ++v)
    for (int u = 0; u < depth_m.cols; ++u) {
      const cv::Point2f place = lens.places.at<cv::Point2f>(v, u);
      const auto inverse_z = interpolated(ideal_m, ideal_ids, place);
      depth_m.at<float>(v, u) = inverse_z ? 1 / *inverse_z : ideal_m.at<float>(nearest(place));
    }
}

}  // namespace uniquadric
