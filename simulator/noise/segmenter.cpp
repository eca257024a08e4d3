#include "simulator/noise/segmenter.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "core/base/random.h"
#include "core/base/vector_clones.h"
#include "simulator/noise/normals.h"
#include "simulator/noise/outline_distance.h"

namespace uniquadric {
namespace {

constexpr double kReach_sigmas = 5;  // the outline's displacement beyond this is cut off: 6e-7 of it

struct TrueMask {
  cv::Rect box;
  std::int64_t pixels = 0;
};

std::map<int, TrueMask> find_masks(const cv::Mat& ids) {
  std::map<int, TrueMask> masks;
  for (int v = 0; v < ids.rows; ++v) {
    const auto* row = ids.ptr<std::uint16_t>(v);
    for (int u = 0; u < ids.cols;) {
      const int id = row[u], begin = u;
      while (u < ids.cols && row[u] == id) ++u;
      if (id == 0) continue;
      TrueMask& mask = masks[id];
      mask.box = mask.pixels ? mask.box | cv::Rect(begin, v, u - begin, 1) : cv::Rect(begin, v, u - begin, 1);
      mask.pixels += u - begin;
    }
  }
  return masks;
}

// Gives `id` to the pixels that the moved outline holds more deeply than what holds them so far.
UNIQUADRIC_VECTOR_CLONES
void add_mask(int id, const cv::Mat& distance_px, const cv::Mat& displacement_px, double sigma_px,
              cv::Mat depth_px, cv::Mat masks) {
  const auto sigma = static_cast<float>(sigma_px);
  for (int v = 0; v < distance_px.rows; ++v) {
    const auto *distance = distance_px.ptr<float>(v), *displacement = displacement_px.ptr<float>(v);
    auto* depth = depth_px.ptr<float>(v);
    auto* mask = masks.ptr<std::uint16_t>(v);
    for (int u = 0; u < distance_px.cols; ++u) {
      const float moved = distance[u] + sigma * displacement[u];
      mask[u] = moved > depth[u] ? static_cast<std::uint16_t>(id) : mask[u];
      depth[u] = std::max(moved, depth[u]);
    }
  }
}

// Unit energy, so that white noise keeps its variance; twice convolved with itself it is the autocorrelation.
cv::Mat smoothing_kernel(double sigma) {
  const int reach = static_cast<int>(std::ceil(4 * sigma));
  cv::Mat kernel(1, 2 * reach + 1, CV_32FC1);
  for (int i = -reach; i <= reach; ++i)
    kernel.at<float>(i + reach) = sigma > 0 ? static_cast<float>(std::exp(-i * i / (2 * sigma * sigma))) : 1;
  return kernel / cv::norm(kernel);
}

}  // namespace

bool is_segmented(const SegmenterNoise& noise, std::int64_t frame) {
  return frame % std::max(noise.every_n_frames, 1) == 0;
}

cv::Mat smooth_field(cv::Size size, double length_px, std::uint64_t seed, std::int64_t frame, int id) {
  constexpr int kNodesALength =
      4;                      // the field is drawn on a grid this fine and interpolated: variance kept to 1 %
  constexpr int kMargin = 2;  // nodes: cubic interpolation looks two to each side
  const int step = std::max(1, static_cast<int>(length_px / kNodesALength));
  const cv::Mat kernel = smoothing_kernel(length_px / std::numbers::sqrt2 / step);
  const int reach = kernel.cols / 2;
  const cv::Size nodes(size.width / step + 1 + 2 * kMargin, size.height / step + 1 + 2 * kMargin);
  cv::Mat white(nodes.height + 2 * reach, nodes.width + 2 * reach, CV_32FC1), smooth, fine;
  RandomStream stream(seed, "segmenter_outline", static_cast<std::uint64_t>(frame),
                      static_cast<std::uint32_t>(id));
  fill_normals(stream, {white.ptr<float>(), white.total()});
  cv::sepFilter2D(white, smooth, CV_32F, kernel, kernel);
  const cv::Mat valid = smooth(cv::Rect(reach, reach, nodes.width, nodes.height)).clone();
  cv::resize(valid, fine, nodes * step, 0, 0, step > 1 ? cv::INTER_CUBIC : cv::INTER_NEAREST);
  return fine(cv::Rect(kMargin * step, kMargin * step, size.width, size.height)).clone();
}

cv::Mat segment(const cv::Mat& ids, const SegmenterNoise& noise, std::uint64_t seed, std::int64_t frame) {
  cv::Mat masks = cv::Mat::zeros(ids.size(), CV_16UC1);
  cv::Mat depth_px = cv::Mat::zeros(ids.size(), CV_32FC1);  // how deep a pixel lies in the mask that holds it
  const int reach = static_cast<int>(std::ceil(kReach_sigmas * noise.boundary_sigma_px)) + 1;
  const int margin = std::min(reach, kMostOutlineReach_px);
  for (const auto& [id, mask] : find_masks(ids)) {
    RandomStream miss(seed, "segmenter_miss", static_cast<std::uint64_t>(frame),
                      static_cast<std::uint32_t>(id));
    if (mask.pixels < noise.min_pixels || miss.uniform() < noise.miss_probability) continue;
    const cv::Rect wide(mask.box.x - margin, mask.box.y - margin, mask.box.width + 2 * margin,
                        mask.box.height + 2 * margin);
    const cv::Rect box = wide & cv::Rect({0, 0}, ids.size());
    const cv::Mat field = smooth_field(box.size(), noise.boundary_length_px, seed, frame, id);
    add_mask(id, outline_distance(ids(box), id, margin), field, noise.boundary_sigma_px, depth_px(box),
             masks(box));
  }
  return masks;
}

}  // namespace uniquadric
