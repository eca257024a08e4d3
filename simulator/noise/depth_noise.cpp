#include "simulator/noise/depth_noise.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <opencv2/core.hpp>
#include <vector>

#include "core/base/random.h"
#include "core/base/vector_clones.h"
#include "simulator/noise/depth_view.h"
#include "simulator/noise/normals.h"
#include "simulator/noise/smooth_field.h"
#include "simulator/noise/stereo_depth.h"

namespace uniquadric {
namespace {

// ours: a floor seen from 1.5 m above steps by 1 % a row at 8 m (f = 525 px), an object's outline by more
// than this
constexpr float kEdgeStep = 0.05f;

RandomStream row_stream(std::uint64_t seed, const char* name, std::int64_t frame, int row) {
  return {seed, name, static_cast<std::uint64_t>(frame), static_cast<std::uint32_t>(row)};
}

// To the nearest step; not below zero, where no depth is. std::round would be a call for each pixel.
inline double rounded(double disparity, double step) {
  const double steps = disparity / step, whole = std::floor(steps);
  return step * (whole + (steps - whole >= 0.5 ? 1 : 0));
}

UNIQUADRIC_VECTOR_CLONES
void add_stereo_noise(const float* __restrict normal, const DepthNoise& noise, double focal_baseline,
                      int count, float* __restrict z_m) {
  const double bias = noise.disparity_bias_px, sigma = noise.disparity_sigma_px;
  const double step = noise.disparity_step_px > 0 ? noise.disparity_step_px : 1;
  const bool is_rounded = noise.disparity_step_px > 0;
  for (int u = 0; u < count; ++u) {
    const double disparity = focal_baseline / z_m[u] + bias + sigma * normal[u];
    const double steps = rounded(disparity, step), measured = is_rounded ? steps : disparity;
    const double back_m = focal_baseline / measured;
    const float noisy_m = measured > 0 ? static_cast<float>(back_m) : 0;
    z_m[u] = z_m[u] > 0 ? noisy_m : z_m[u];
  }
}

// Standard normal numbers, a row a stream, or one field of them that is smooth over some pixels.
cv::Mat draw_normals(cv::Size size, double correlation_px, std::uint64_t seed, std::int64_t frame) {
  if (correlation_px > 0)
    return smooth_field(size, correlation_px, {seed, "depth_noise_field", static_cast<std::uint64_t>(frame)});
  cv::Mat normals(size, CV_32FC1);
  for (int v = 0; v < size.height; ++v) {
    RandomStream stream = row_stream(seed, "depth_noise", frame, v);
    fill_normals(stream, {normals.ptr<float>(v), static_cast<std::size_t>(size.width)});
  }
  return normals;
}

void add_noise(cv::Mat& depth_m, const Camera& camera, const DepthNoise& noise, std::uint64_t seed,
               std::int64_t frame) {
  const bool is_stereo = noise.model == DepthNoise::Model::stereo;
  const cv::Mat normals = draw_normals(depth_m.size(), is_stereo ? noise.correlation_px : 0, seed, frame);
  const float k = static_cast<float>(noise.k);
  for (int v = 0; v < depth_m.rows; ++v) {
    const auto* normal = normals.ptr<float>(v);
    auto* z_m = depth_m.ptr<float>(v);
    if (is_stereo)
      add_stereo_noise(normal, noise, camera.fx * noise.baseline_m, depth_m.cols, z_m);
    else
      for (int u = 0; u < depth_m.cols; ++u) z_m[u] *= 1 + k * normal[u];
  }
}

// Errors of stereo that are no noise.
void see_twice(cv::Mat& depth_m, const cv::Mat& edges, const PixelRays& rays, const DepthNoise& noise,
               std::uint64_t seed, std::int64_t frame) {
  cv::Mat lost = cv::Mat::zeros(depth_m.size(), CV_8UC1);
  if (noise.shadow) lost |= stereo_shadow(depth_m, rays.camera.fx * noise.baseline_m, rays.columns);
  if (noise.max_incidence_deg < 90) lost |= flat_incidence(depth_m, rays, noise.max_incidence_deg);
  if (noise.smear_px > 0) smear_disparity(depth_m, edges, noise.smear_px);
  scatter_edges(depth_m, edges, noise.flying_pixels, seed, frame);
  depth_m.setTo(0, lost);
}

void drop_edges(cv::Mat& depth_m, const cv::Mat& edges, double probability, std::uint64_t seed,
                std::int64_t frame) {
  for (int v = 0; v < depth_m.rows; ++v) {
    RandomStream stream = row_stream(seed, "depth_edge", frame, v);
    const auto* edge = edges.ptr<std::uint8_t>(v);
    for (int u = 0; u < depth_m.cols; ++u) {
      std::uint64_t eight = 1;
      if (u + 8 <= depth_m.cols) std::memcpy(&eight, edge + u, 8);
      if (eight == 0)
        u += 7;  // most are no edge: quicker past them
      else if (edge[u] && stream.uniform() < probability)
        depth_m.at<float>(v, u) = 0;
    }
  }
}

// What surfaces return whose three channels have that sum.
std::vector<double> returns_of_sums(const DepthNoise& noise) {
  std::vector<double> returns;
  for (int sum = 0; sum <= 3 * 255; ++sum) {
    const double grey = sum / 3.0;
    returns.push_back(1 - noise.dark_dropout * std::max(0.0, 1 - grey / noise.dark_level));
  }
  return returns;
}

// A pixel returns less the darker it is, and as much as its fourth channel says.
void drop_faint(cv::Mat& depth_m, const cv::Mat& rgba, const DepthNoise& noise, std::uint64_t seed,
                std::int64_t frame) {
  const std::vector<double> returns = returns_of_sums(noise);
  const auto lost_share = [&](const cv::Vec4b& c) {
    const double returned = returns[static_cast<std::size_t>(c[0] + c[1] + c[2])];
    return c[3] == 255 ? 1 - returned : 1 - c[3] / 255.0 * returned;
  };
  for (int v = 0; v < depth_m.rows; ++v) {
    RandomStream stream = row_stream(seed, "depth_faint", frame, v);
    const auto* color = rgba.ptr<cv::Vec4b>(v);
    for (int u = 0; u < depth_m.cols; ++u) {
      if (color[u][3] == 255 && noise.dark_dropout == 0) continue;  // most images: nothing is lost
      if (const double lost = lost_share(color[u]); lost > 0 && stream.uniform() < lost)
        depth_m.at<float>(v, u) = 0;
    }
  }
}

UNIQUADRIC_VECTOR_CLONES
void drop_out_of_range(cv::Mat& depth_m, const DepthNoise& noise) {
  const float min_m = static_cast<float>(noise.min_range_m), max_m = static_cast<float>(noise.max_range_m);
  for (int v = 0; v < depth_m.rows; ++v) {
    auto* z_m = depth_m.ptr<float>(v);
    for (int u = 0; u < depth_m.cols; ++u) z_m[u] = z_m[u] >= min_m && z_m[u] <= max_m ? z_m[u] : 0;
  }
}

// Marks both pixels of each pair (a[i], b[i]) that an edge runs between. `edge` is a place to work in, so
// that the compiler can look at many pairs at once.
UNIQUADRIC_VECTOR_CLONES
void mark_edges(const float* __restrict a_m, const float* __restrict b_m, int count,
                std::uint8_t* __restrict edge, std::uint8_t* edge_a, std::uint8_t* edge_b) {
  for (int i = 0; i < count; ++i) {
    const float step = std::abs(a_m[i] - b_m[i]), near = a_m[i] < b_m[i] ? a_m[i] : b_m[i];
    edge[i] = step > kEdgeStep * near ? 255 : 0;
  }
  for (int i = 0; i < count; ++i) edge_a[i] |= edge[i];
  for (int i = 0; i < count; ++i) edge_b[i] |= edge[i];
}

}  // namespace

cv::Mat depth_edges(const cv::Mat& depth_m) {
  cv::Mat edges = cv::Mat::zeros(depth_m.size(), CV_8UC1);
  std::vector<std::uint8_t> pair(static_cast<std::size_t>(depth_m.cols));
  for (int v = 0; v < depth_m.rows; ++v) {
    const auto* z_m = depth_m.ptr<float>(v);
    auto* edge = edges.ptr<std::uint8_t>(v);
    mark_edges(z_m, z_m + 1, depth_m.cols - 1, pair.data(), edge, edge + 1);
    if (v + 1 < depth_m.rows)
      mark_edges(z_m, depth_m.ptr<float>(v + 1), depth_m.cols, pair.data(), edge,
                 edges.ptr<std::uint8_t>(v + 1));
  }
  return edges;
}

cv::Mat add_depth_noise(const cv::Mat& depth_m, const cv::Mat& rgba, const PixelRays& rays,
                        const DepthNoise& noise, std::uint64_t seed, std::int64_t frame) {
  cv::Mat noisy = depth_m.clone();
  if (noise.model != DepthNoise::Model::none) {
    const cv::Mat edges = depth_edges(depth_m);
    if (noise.model == DepthNoise::Model::stereo) see_twice(noisy, edges, rays, noise, seed, frame);
    add_noise(noisy, rays.camera, noise, seed, frame);
    if (noise.edge_dropout > 0) drop_edges(noisy, edges, noise.edge_dropout, seed, frame);
    if (!rgba.empty()) drop_faint(noisy, rgba, noise, seed, frame);
  }
  drop_out_of_range(noisy, noise);
  return seen_from_depth_camera(noisy, depth_m, rays, noise);
}

}  // namespace uniquadric
