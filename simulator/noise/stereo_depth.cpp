#include "simulator/noise/stereo_depth.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <vector>

#include "core/base/random.h"
#include "core/base/vector_clones.h"

namespace uniquadric {
namespace {

// Inverse depth is affine in pixel coordinates on a plane: exact differences give the plane. Along one
// direction, of the two one-sided differences the smaller: it does not reach across an edge.
inline float difference(float before, float here, float after) {
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

// Squared cosine of the angle between a pixel's ray (x, y, 1) and its surface's normal (nx, ny, nz). A plane
// n . X = h has the inverse depth n . (x, y, 1) / h, which is `here`.
inline float square_cos(float here, float nx, float ny, float x, float y) {
  const float nz = here - x * nx - y * ny;
  return here * here / ((nx * nx + ny * ny + nz * nz) * (x * x + y * y + 1));
}

// Whether both are numbers, in a way that the compiler can ask of many pixels at once.
inline bool are_finite(float a, float b) {
  constexpr float kMost = std::numeric_limits<float>::max();
  return (std::abs(a) <= kMost) & (std::abs(b) <= kMost);
}

bool is_flat_behind_lens(const cv::Mat& depth_m, const PixelRays& rays, int u, int v, float least_square) {
  const Eigen::Vector2f slope = slope_behind_lens(depth_m, rays, u, v), ray = rays.at(u, v).cast<float>();
  return are_finite(slope.x(), slope.y()) &&
         square_cos(inverse(depth_m.at<float>(v, u)), slope.x(), slope.y(), ray.x(), ray.y()) < least_square;
}

cv::Mat flat_behind_lens(const cv::Mat& depth_m, const PixelRays& rays, float least_square) {
  cv::Mat flat = cv::Mat::zeros(depth_m.size(), CV_8UC1);
  for (int v = 0; v < depth_m.rows; ++v)
    for (int u = 0; u < depth_m.cols; ++u)
      if (depth_m.at<float>(v, u) > 0 && is_flat_behind_lens(depth_m, rays, u, v, least_square))
        flat.at<std::uint8_t>(v, u) = 255;
  return flat;
}

// Inverse depth with a rim of nothing about the image, for which it is infinite.
cv::Mat inverse_with_rim(const cv::Mat& depth_m) {
  cv::Mat inverse_z(depth_m.rows + 2, depth_m.cols + 2, CV_32FC1,
                    cv::Scalar(std::numeric_limits<float>::infinity()));
  for (int v = 0; v < depth_m.rows; ++v) {
    const auto* z_m = depth_m.ptr<float>(v);
    auto* out = inverse_z.ptr<float>(v + 1) + 1;
    for (int u = 0; u < depth_m.cols; ++u) out[u] = inverse(z_m[u]);
  }
  return inverse_z;
}

// A row of the image: inverse depths there, above and below, and the rays (x, y, 1).
struct IncidenceRow {
  const float *above, *here, *below, *x;
  float y, fx, fy;
};

// Where `here` is nothing its differences are no numbers.
UNIQUADRIC_VECTOR_CLONES
void mark_flat(const IncidenceRow& row, float least_square, int count, std::uint8_t* __restrict flat) {
  const float *above = row.above, *here = row.here, *below = row.below, *x = row.x;
  const float y = row.y, fx = row.fx, fy = row.fy;
  for (int u = 0; u < count; ++u) {
    const float nx = fx * difference(here[u - 1], here[u], here[u + 1]);
    const float ny = fy * difference(above[u], here[u], below[u]);
    const bool is_flat = square_cos(here[u], nx, ny, x[u], y) < least_square;
    flat[u] = is_flat & are_finite(nx, ny) ? 255 : 0;
  }
}

// The columns' places in the second image; none where there is no depth.
UNIQUADRIC_VECTOR_CLONES
void see_second(const float* __restrict z_m, const double* __restrict columns, double focal_baseline,
                int count, double* __restrict second) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  for (int u = 0; u < count; ++u) {
    const double place = columns[u] - focal_baseline / z_m[u];
    second[u] = z_m[u] > 0 ? place : kNone;
  }
}

}  // namespace

cv::Mat stereo_shadow(const cv::Mat& depth_m, double focal_baseline, const cv::Mat& columns) {
  cv::Mat shadow(depth_m.size(), CV_8UC1);
  std::vector<double> straight(static_cast<std::size_t>(depth_m.cols)), second(straight.size());
  std::iota(straight.begin(), straight.end(), 0);
  for (int v = 0; v < depth_m.rows; ++v) {
    see_second(depth_m.ptr<float>(v), columns.empty() ? straight.data() : columns.ptr<double>(v),
               focal_baseline, depth_m.cols, second.data());
    auto* hidden = shadow.ptr<std::uint8_t>(v);
    double leftmost =
        std::numeric_limits<double>::infinity();  // in the second image, of what lies to the right
    for (int u = depth_m.cols - 1; u >= 0; --u) {
      const double place = second[static_cast<std::size_t>(u)];
      hidden[u] = place >= leftmost ? 255 : 0;
      leftmost = place < leftmost ? place : leftmost;
    }
  }
  return shadow;
}

cv::Mat flat_incidence(const cv::Mat& depth_m, const PixelRays& rays, double max_incidence_deg) {
  const double least = std::cos(max_incidence_deg * std::numbers::pi / 180);
  const auto least_square = static_cast<float>(least * least);
  if (!rays.rays.empty()) return flat_behind_lens(depth_m, rays, least_square);
  const cv::Mat inverse_z = inverse_with_rim(depth_m);
  std::vector<float> x;
  for (int u = 0; u < depth_m.cols; ++u) x.push_back(static_cast<float>(rays.at(u, 0).x()));
  cv::Mat flat(depth_m.size(), CV_8UC1);
  for (int v = 0; v < depth_m.rows; ++v) {
    const IncidenceRow row{inverse_z.ptr<float>(v) + 1,           inverse_z.ptr<float>(v + 1) + 1,
                           inverse_z.ptr<float>(v + 2) + 1,       x.data(),
                           static_cast<float>(rays.at(0, v).y()), static_cast<float>(rays.camera.fx),
                           static_cast<float>(rays.camera.fy)};
    mark_flat(row, least_square, depth_m.cols, flat.ptr<std::uint8_t>(v));
  }
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
