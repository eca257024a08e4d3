#include "simulator/noise/stereo_depth.h"

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

// Squared cosine of the angle between a pixel's ray (x, y, 1) and its surface's normal, nothing's being 1. A
// plane n . X = h has the inverse depth n . (x, y, 1) / h.
float square_cos_incidence(const cv::Mat& depth_m, const Camera& camera, int u, int v) {
  const float here = inverse(depth_m.at<float>(v, u));
  const auto at = [&](int column, int row) {
    const bool inside = column >= 0 && row >= 0 && column < depth_m.cols && row < depth_m.rows;
    return inside ? inverse(depth_m.at<float>(row, column)) : std::numeric_limits<float>::infinity();
  };
  const float nx = static_cast<float>(camera.fx) * difference(at(u - 1, v), here, at(u + 1, v));
  const float ny = static_cast<float>(camera.fy) * difference(at(u, v - 1), here, at(u, v + 1));
  if (!std::isfinite(nx) || !std::isfinite(ny)) return 1;
  const float x = static_cast<float>((u - camera.cx) / camera.fx);
  const float y = static_cast<float>((v - camera.cy) / camera.fy);
  const float nz = here - x * nx - y * ny;
  return here * here / ((nx * nx + ny * ny + nz * nz) * (x * x + y * y + 1));
}

}  // namespace

cv::Mat stereo_shadow(const cv::Mat& depth_m, double focal_baseline) {
  cv::Mat shadow = cv::Mat::zeros(depth_m.size(), CV_8UC1);
  for (int v = 0; v < depth_m.rows; ++v) {
    const auto* z_m = depth_m.ptr<float>(v);
    double leftmost =
        std::numeric_limits<double>::infinity();  // in the second image, of what lies to the right
    for (int u = depth_m.cols - 1; u >= 0; --u) {
      if (!(z_m[u] > 0)) continue;
      const double second = u - focal_baseline / z_m[u];
      if (second >= leftmost) shadow.at<std::uint8_t>(v, u) = 255;
      leftmost = std::min(leftmost, second);
    }
  }
  return shadow;
}

cv::Mat flat_incidence(const cv::Mat& depth_m, const Camera& camera, double max_incidence_deg) {
  const double least = std::cos(max_incidence_deg * std::numbers::pi / 180);
  const auto least_square = static_cast<float>(least * least);
  cv::Mat flat = cv::Mat::zeros(depth_m.size(), CV_8UC1);
  for (int v = 0; v < depth_m.rows; ++v)
    for (int u = 0; u < depth_m.cols; ++u)
      if (depth_m.at<float>(v, u) > 0 && square_cos_incidence(depth_m, camera, u, v) < least_square)
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
