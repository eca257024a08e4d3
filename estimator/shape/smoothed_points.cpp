#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "estimator/shape/even_choice.h"
#include "estimator/shape/object_points.h"

namespace uniquadric {
namespace {

constexpr double kOutlierSigmas = 2.5;  // off the first plane
constexpr double kLeastScatter = 1e-4;  // of inverse depth, relative: a noise-free plane has none
constexpr double kMinShare = 0.4;       // of the window that must lie on the plane
constexpr double kSliverShare = 0.2;    // of the largest part; larger ones are the body's too,
constexpr double kDeepest = 3;          // if they are no more lengths of the mask before or behind it

// Inverse depth over pixel offsets, linear on a plane.
struct Plane {
  double at_pixel = 0, by_u = 0, by_v = 0;
  double at(int du, int dv) const { return at_pixel + by_u * du + by_v * dv; }
};

struct Window {
  const cv::Mat& inverse_depth;  // CV_32FC1 under the mask, 0 elsewhere
  int u, v, half;

  template <typename Visit>
  void each(const Visit& visit) const {
    for (int y = std::max(0, v - half); y <= std::min(inverse_depth.rows - 1, v + half); ++y) {
      const float* row = inverse_depth.ptr<float>(y);
      for (int x = std::max(0, u - half); x <= std::min(inverse_depth.cols - 1, u + half); ++x)
        if (row[x] > 0) visit(x - u, y - v, static_cast<double>(row[x]));
    }
  }
};

struct PlaneFit {
  Plane plane;
  double scatter = 0;  // standard deviation about it
  int count = 0;
};

// Least squares over what lies within `gate` of `near`.
std::optional<PlaneFit> fit_plane(const Window& window, const Plane& near, double gate) {
  int count = 0, u = 0, v = 0, uu = 0, uv = 0, vv = 0;  // sums over the window
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  double squares = 0;
  window.each([&](int du, int dv, double w) {
    const double off = w - near.at(du, dv);
    if (std::abs(off) > gate) return;
    ++count, u += du, v += dv, uu += du * du, uv += du * dv, vv += dv * dv;
    right += off * Eigen::Vector3d(1, du, dv);
    squares += off * off;
  });
  if (count < 6) return std::nullopt;
  Eigen::Matrix3d normal;
  normal << count, u, v, u, uu, uv, v, uv, vv;
  const Eigen::Vector3d change = normal.inverse() * right;
  if (!change.allFinite()) return std::nullopt;  // all in one line
  const double left = std::max(0.0, squares - change.dot(right));
  return PlaneFit{{near.at_pixel + change[0], near.by_u + change[1], near.by_v + change[2]},
                  std::sqrt(left / (count - 3)),
                  count};
}

// Pixels that hang together without a jump in depth.
std::vector<std::vector<cv::Point>> surfaces(const cv::Mat& inverse_depth, double edge_ratio) {
  cv::Mat open = inverse_depth > 0;
  std::vector<std::vector<cv::Point>> parts;
  for (int v = 0; v < open.rows; ++v)
    for (int u = 0; u < open.cols; ++u) {
      if (!open.at<unsigned char>(v, u)) continue;
      std::vector<cv::Point>& part = parts.emplace_back(1, cv::Point(u, v));
      open.at<unsigned char>(v, u) = 0;
      for (std::size_t i = 0; i < part.size(); ++i) {
        const cv::Point from = part[i];
        const float here = inverse_depth.at<float>(from);
        for (const cv::Point step : {cv::Point(-1, 0), {1, 0}, {0, -1}, {0, 1}}) {
          const cv::Point to = from + step;
          if (!cv::Rect({}, open.size()).contains(to) || !open.at<unsigned char>(to)) continue;
          if (std::abs(inverse_depth.at<float>(to) - here) > edge_ratio * here) continue;
          open.at<unsigned char>(to) = 0;
          part.push_back(to);
        }
      }
    }
  return parts;
}

double mean_at(const cv::Mat& image, const std::vector<cv::Point>& pixels) {
  double mean = 0;
  for (const cv::Point& p : pixels) mean += image.at<float>(p) / static_cast<double>(pixels.size());
  return mean;
}

// A mask that reaches over the body's edge takes in slivers of what lies behind or before it: small parts
// whose depth is not that of the largest, or parts so far from it that a body of the mask's length ends
// before.
void drop_slivers(cv::Mat& inverse_depth, double edge_ratio, double focal_px) {
  const cv::Rect box = cv::boundingRect(inverse_depth > 0);
  const double length = std::hypot(box.width, box.height) / focal_px;  // at a depth of 1
  const auto parts = surfaces(inverse_depth, edge_ratio);
  const auto larger = [](const auto& a, const auto& b) { return a.size() < b.size(); };
  const auto main = std::max_element(parts.begin(), parts.end(), larger);
  if (main == parts.end()) return;
  const auto at = [&](const cv::Point& p) { return inverse_depth.at<float>(p); };
  const auto nearer = [&](const cv::Point& a, const cv::Point& b) { return at(a) < at(b); };
  const auto [far, near] = std::minmax_element(main->begin(), main->end(), nearer);
  const double lowest = at(*far), highest = at(*near);
  const double middle = mean_at(inverse_depth, *main);
  for (const auto& part : parts) {
    const double mean = mean_at(inverse_depth, part);
    const bool is_small =
        static_cast<double>(part.size()) <= kSliverShare * static_cast<double>(main->size());
    const bool is_far = std::abs(1 / mean - 1 / middle) > kDeepest * length / middle;
    if (!is_far && (!is_small || (mean >= lowest && mean <= highest))) continue;
    for (const cv::Point& p : part) inverse_depth.at<float>(p) = 0;
  }
}

// The surface at a pixel; nothing where too little of the window belongs to it.
std::optional<Plane> surface_at(const Window& window, double edge_ratio) {
  const double here = window.inverse_depth.at<float>(window.v, window.u);
  const auto rough = fit_plane(window, {here, 0, 0}, edge_ratio * here);
  if (!rough) return std::nullopt;
  const double gate = kOutlierSigmas * std::max(rough->scatter, kLeastScatter * here);
  const auto fine = fit_plane(window, rough->plane, gate);
  const int side = 2 * window.half + 1;
  if (!fine || fine->count < kMinShare * side * side) return std::nullopt;
  if (std::abs(fine->plane.at_pixel - here) > edge_ratio * here) return std::nullopt;
  return fine->plane;
}

// A plane of inverse depth, w = w0 + a (u - u0) + b (v - v0), is n . p = 1 with n = (fx a, fy b, w - a (u0 -
// cx)
// - b (v0 - cy)) in the camera's frame: w = n . ray. It is taken at the undistorted pixel.
Eigen::Vector3d normal_of(const Plane& plane, const Eigen::Vector3d& ray, const Camera& camera) {
  const double a = camera.fx * plane.by_u, b = camera.fy * plane.by_v;
  return -Eigen::Vector3d(a, b, plane.at_pixel - a * ray.x() - b * ray.y()).normalized();
}

}  // namespace

SurfacePoints smoothed_points(const cv::Mat& depth, const cv::Mat& mask, const Camera& camera,
                              const PointOptions& options) {
  cv::Mat inverse_depth = cv::Mat::zeros(depth.size(), CV_32FC1);
  for (int v = 0; v < depth.rows; ++v)
    for (int u = 0; u < depth.cols; ++u) {
      const float z = depth.at<float>(v, u);
      if (mask.at<unsigned char>(v, u) && z > 0 && z < options.max_depth_m)
        inverse_depth.at<float>(v, u) = 1 / z;
    }
  drop_slivers(inverse_depth, options.edge_ratio, camera.fx);
  std::vector<cv::Point> pixels;
  cv::findNonZero(inverse_depth > 0, pixels);
  const auto chosen = even_choice(std::ssize(pixels), options.max_points);
  SurfacePoints result{Eigen::Matrix3Xd(3, std::ssize(chosen)), Eigen::Matrix3Xd(3, std::ssize(chosen))};
  Eigen::Index count = 0;
  for (const auto i : chosen) {
    const cv::Point pixel = pixels[i];
    const auto plane = surface_at({inverse_depth, pixel.x, pixel.y, options.smooth_px}, options.edge_ratio);
    const auto ray = camera.unproject({pixel.x, pixel.y});
    if (!plane || !ray) continue;
    result.points.col(count) = *ray / plane->at_pixel;
    result.normals.col(count++) = normal_of(*plane, *ray, camera);
  }
  if (count < options.min_points) count = 0;
  return {result.points.leftCols(count), result.normals.leftCols(count)};
}

}  // namespace uniquadric
