#include "simulator/noise/depth_noise.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/random.h"
#include "simulator/noise/normals.h"

namespace uniquadric {
namespace {

// ours: a floor seen from 1.5 m above steps by 1 % a row at 8 m (f = 525 px), an object's outline by more
// than this
constexpr float kEdgeStep = 0.05f;

RandomStream row_stream(std::uint64_t seed, const char* name, std::int64_t frame, int row) {
  return {seed, name, static_cast<std::uint64_t>(frame), static_cast<std::uint32_t>(row)};
}

bool is_edge(float a, float b) {
  return std::abs(a - b) > kEdgeStep * std::min(a, b);
}

float stereo_z(float z_m, float normal, const DepthNoise& noise, double focal_baseline) {
  const double disparity = focal_baseline / z_m + noise.disparity_sigma_px * normal;
  const double step = noise.disparity_step_px;
  const double measured = step > 0 ? step * std::round(disparity / step) : disparity;
  return measured > 0 ? static_cast<float>(focal_baseline / measured) : 0;
}

void add_noise(cv::Mat& depth_m, const Camera& camera, const DepthNoise& noise, std::uint64_t seed,
               std::int64_t frame) {
  std::vector<float> normals(static_cast<std::size_t>(depth_m.cols));
  const float k = static_cast<float>(noise.k);
  for (int v = 0; v < depth_m.rows; ++v) {
    RandomStream stream = row_stream(seed, "depth_noise", frame, v);
    fill_normals(stream, normals);
    auto* z_m = depth_m.ptr<float>(v);
    for (int u = 0; u < depth_m.cols; ++u) {
      if (z_m[u] <= 0) continue;
      z_m[u] = noise.model == DepthNoise::Model::proportional
                   ? z_m[u] * (1 + k * normals[u])
                   : stereo_z(z_m[u], normals[u], noise, camera.fx * noise.baseline_m);
    }
  }
}

void drop_edges(cv::Mat& depth_m, const cv::Mat& edges, double probability, std::uint64_t seed,
                std::int64_t frame) {
  for (int v = 0; v < depth_m.rows; ++v) {
    RandomStream stream = row_stream(seed, "depth_edge", frame, v);
    const auto* edge = edges.ptr<std::uint8_t>(v);
    for (int u = 0; u < depth_m.cols; ++u)
      if (edge[u] && stream.uniform() < probability) depth_m.at<float>(v, u) = 0;
  }
}

void drop_out_of_range(cv::Mat& depth_m, const DepthNoise& noise) {
  for (int v = 0; v < depth_m.rows; ++v) {
    auto* z_m = depth_m.ptr<float>(v);
    for (int u = 0; u < depth_m.cols; ++u)
      if (!(z_m[u] >= noise.min_range_m && z_m[u] <= noise.max_range_m)) z_m[u] = 0;
  }
}

}  // namespace

cv::Mat depth_edges(const cv::Mat& depth_m) {
  cv::Mat edges = cv::Mat::zeros(depth_m.size(), CV_8UC1);
  for (int v = 0; v < depth_m.rows; ++v) {
    const auto* here = depth_m.ptr<float>(v);
    const auto* below = depth_m.ptr<float>(std::min(v + 1, depth_m.rows - 1));
    auto* edge = edges.ptr<std::uint8_t>(v);
    auto* edge_below = edges.ptr<std::uint8_t>(std::min(v + 1, depth_m.rows - 1));
    for (int u = 0; u < depth_m.cols; ++u) {
      if (u + 1 < depth_m.cols && is_edge(here[u], here[u + 1])) edge[u] = edge[u + 1] = 255;
      if (is_edge(here[u], below[u])) edge[u] = edge_below[u] = 255;
    }
  }
  return edges;
}

cv::Mat add_depth_noise(const cv::Mat& depth_m, const Camera& camera, const DepthNoise& noise,
                        std::uint64_t seed, std::int64_t frame) {
  cv::Mat noisy = depth_m.clone();
  if (noise.model != DepthNoise::Model::none) {
    add_noise(noisy, camera, noise, seed, frame);
    if (noise.edge_dropout > 0) drop_edges(noisy, depth_edges(depth_m), noise.edge_dropout, seed, frame);
  }
  drop_out_of_range(noisy, noise);
  return noisy;
}

}  // namespace uniquadric
