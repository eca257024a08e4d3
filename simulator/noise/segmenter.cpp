#include "simulator/noise/segmenter.h"

#include <algorithm>
#include <cmath>

#include "core/base/random.h"
#include "core/base/vector_clones.h"
#include "simulator/noise/mask_faults.h"
#include "simulator/noise/outline_distance.h"
#include "simulator/noise/smooth_field.h"
#include "simulator/noise/true_masks.h"

namespace uniquadric {
namespace {

constexpr double kReach_sigmas = 5;  // the outline's displacement beyond this is cut off: 6e-7 of it

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

}  // namespace

bool is_segmented(const SegmenterNoise& noise, std::uint64_t seed, std::int64_t frame, double rate_hz) {
  if (frame % std::max(noise.every_n_frames, 1) != 0) return false;
  if (noise.outage_every_s <= 0) return true;
  const double time_s = static_cast<double>(frame) / rate_hz;
  const double period = std::floor(time_s / noise.outage_every_s);
  RandomStream random(seed, "segmenter_outage", static_cast<std::uint64_t>(period));
  const double begin_s =
      period * noise.outage_every_s + random.uniform() * std::max(0.0, noise.outage_every_s - noise.outage_s);
  return time_s < begin_s || time_s >= begin_s + noise.outage_s;
}

double latency_s(const SegmenterNoise& noise, std::uint64_t seed, std::int64_t frame) {
  constexpr double kNone_s = 1e-9;  // no stamp shows less
  if (noise.latency_s < kNone_s) return 0;
  RandomStream random(seed, "segmenter_latency", static_cast<std::uint64_t>(frame));
  // a logarithm of this deviation, whose mean lies below that of latency_s by half its square
  const double deviation = std::sqrt(2 * std::log(std::hypot(1, noise.latency_sigma_s / noise.latency_s)));
  return noise.latency_s * std::exp(deviation * (random.normal() - 0.5 * deviation));
}

cv::Mat segment(const cv::Mat& true_ids, const SegmenterNoise& noise, std::uint64_t seed, std::int64_t frame,
                double rate_hz, const std::set<int>& objects) {
  const cv::Mat ids = mask_faults(true_ids, noise, seed, static_cast<double>(frame) / rate_hz, objects);
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
    const cv::Mat field = smooth_field(
        box.size(), noise.boundary_length_px,
        {seed, "segmenter_outline", static_cast<std::uint64_t>(frame), static_cast<std::uint32_t>(id)});
    add_mask(id, outline_distance(ids(box), id, margin), field, noise.boundary_sigma_px, depth_px(box),
             masks(box));
  }
  return masks;
}

}  // namespace uniquadric
