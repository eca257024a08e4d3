#include "simulator/noise/stereo_depth.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/base/random.h"

namespace uniquadric {
namespace {

// Inverse depth is affine in pixel coordinates on a plane: exact differences give the plane. Along one
// direction, of the two one-sided differences the smaller: it does not reach across an edge.
float difference(float before, float here, float after) {
  const float back = here - before, on = after - here;
  return std::abs(back) < std::abs(on) ? back : on;
}

float inverse(float z_m) {
  return z_m > 0 ? 1 / z_m : std::numeric_limits<float>::infinity();  // never the smaller difference
}

// A pixel's four neighbours inside the image; at its border the pixel itself.
std::array<cv::Point, 4> neighbours(const cv::Mat& image, int u, int v) {
  return {cv::Point(std::max(u - 1, 0), v),
          {std::min(u + 1, image.cols - 1), v},
          {u, std::max(v - 1, 0)},
          {u, std::min(v + 1, image.rows - 1)}};
}

// The step to a pixel's neighbour before it or after it, as difference() chooses: of inverse depth and ray.
struct Step {
  float inverse_z = std::numeric_limits<float>::infinity();
  Eigen::Vector2f ray = Eigen::Vector2f::Zero();
};

Step smaller_step(const cv::Mat& depth_m, const PixelRays& rays, const cv::Point& here,
                  const cv::Point& along) {
  Step step;
  for (const int side : {-1, 1}) {
    const cv::Point there = here + side * along;
    if (!cv::Rect({0, 0}, depth_m.size()).contains(there)) continue;
    const float change = inverse(depth_m.at<float>(there)) - inverse(depth_m.at<float>(here));
    if (std::abs(change) < std::abs(step.inverse_z))
      step = {change, (rays.at(there.x, there.y) - rays.at(here.x, here.y)).cast<float>()};
  }
  return step;
}

// How inverse depth changes with the ray (x, y, 1): of the two steps the plane that holds both. Infinite
// where there is none.
Eigen::Vector2f slope_behind_lens(const cv::Mat& depth_m, const PixelRays& rays, int u, int v) {
  const Step across = smaller_step(depth_m, rays, {u, v}, {1, 0}),
             down = smaller_step(depth_m, rays, {u, v}, {0, 1});
  Eigen::Matrix2f steps;
  steps << across.ray.transpose(), down.ray.transpose();
  const Eigen::Vector2f changes(across.inverse_z, down.inverse_z);
  if (!changes.allFinite()) return changes;
  return steps.inverse() * changes;
}

Eigen::Vector2f slope_without_lens(const cv::Mat& depth_m, const Camera& camera, int u, int v) {
  const float here = inverse(depth_m.at<float>(v, u));
  const auto at = [&](int column, int row) {
    const bool inside = column >= 0 && row >= 0 && column < depth_m.cols && row < depth_m.rows;
    return inside ? inverse(depth_m.at<float>(row, column)) : std::numeric_limits<float>::infinity();
  };
  return {static_cast<float>(camera.fx) * difference(at(u - 1, v), here, at(u + 1, v)),
          static_cast<float>(camera.fy) * difference(at(u, v - 1), here, at(u, v + 1))};
}

// Squared cosine of the angle between a pixel's ray (x, y, 1) and its surface's normal, nothing's being 1. A
// plane n . X = h has the inverse depth n . (x, y, 1) / h.
float square_cos_incidence(const cv::Mat& depth_m, const PixelRays& rays, int u, int v) {
  const float here = inverse(depth_m.at<float>(v, u));
  const Eigen::Vector2f slope = rays.rays.empty() ? slope_without_lens(depth_m, rays.camera, u, v)
                                                  : slope_behind_lens(depth_m, rays, u, v);
  const float nx = slope.x(), ny = slope.y();
  if (!std::isfinite(nx) || !std::isfinite(ny)) return 1;
  const Eigen::Vector2f ray = rays.at(u, v).cast<float>();
  const float x = ray.x(), y = ray.y();
  const float nz = here - x * nx - y * ny;
  return here * here / ((nx * nx + ny * ny + nz * nz) * (x * x + y * y + 1));
}

}  // namespace

cv::Mat stereo_shadow(const cv::Mat& depth_m, double focal_baseline, const cv::Mat& columns) {
  cv::Mat shadow = cv::Mat::zeros(depth_m.size(), CV_8UC1);
  for (int v = 0; v < depth_m.rows; ++v) {
    const auto* z_m = depth_m.ptr<float>(v);
    double leftmost =
        std::numeric_limits<double>::infinity();  // in the second image, of what lies to the right
    for (int u = depth_m.cols - 1; u >= 0; --u) {
      if (!(z_m[u] > 0)) continue;
      const double column = columns.empty() ? u : columns.at<double>(v, u);
      const double second = column - focal_baseline / z_m[u];
      if (second >= leftmost) shadow.at<std::uint8_t>(v, u) = 255;
      leftmost = std::min(leftmost, second);
    }
  }
  return shadow;
}

cv::Mat flat_incidence(const cv::Mat& depth_m, const PixelRays& rays, double max_incidence_deg) {
  const double least = std::cos(max_incidence_deg * std::numbers::pi / 180);
  const auto least_square = static_cast<float>(least * least);
  cv::Mat flat = cv::Mat::zeros(depth_m.size(), CV_8UC1);
  for (int v = 0; v < depth_m.rows; ++v)
    for (int u = 0; u < depth_m.cols; ++u)
      if (depth_m.at<float>(v, u) > 0 && square_cos_incidence(depth_m, rays, u, v) < least_square)
        flat.at<std::uint8_t>(v, u) = 255;
  return flat;
}

void scatter_edges(cv::Mat& depth_m, const cv::Mat& edges, double probability, std::uint64_t seed,
                   std::int64_t frame) {
  const cv::Mat exact_m = depth_m.clone();
  for (int v = 0; v < depth_m.rows; ++v) {
    RandomStream stream(seed, "depth_flying", static_cast<std::uint64_t>(frame),
                        static_cast<std::uint32_t>(v));
    for (int u = 0; u < depth_m.cols; ++u) {
      if (!edges.at<std::uint8_t>(v, u) || !(exact_m.at<float>(v, u) > 0) || stream.uniform() >= probability)
        continue;
      float near_m = exact_m.at<float>(v, u), far_m = near_m;
      for (const cv::Point& p : neighbours(exact_m, u, v))
        if (const float z_m = exact_m.at<float>(p); z_m > 0)
          near_m = std::min(near_m, z_m), far_m = std::max(far_m, z_m);
      depth_m.at<float>(v, u) = static_cast<float>(stream.uniform(near_m, far_m));
    }
  }
}

}  // namespace uniquadric
