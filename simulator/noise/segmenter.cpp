#include "simulator/noise/segmenter.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "core/base/random.h"
#include "simulator/noise/normals.h"

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

// Distance to the outline [px], positive inside; the outline runs midway between the pixels on its two sides.
cv::Mat signed_distance(const cv::Mat& inside) {
  cv::Mat outside, within, beyond;
  cv::bitwise_not(inside, outside);
  cv::distanceTransform(inside, within, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  cv::distanceTransform(outside, beyond, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  cv::Mat distance = within - beyond;
  cv::subtract(distance, 0.5, distance, inside);
  cv::add(distance, 0.5, distance, outside);
  return distance;
}

// Gives `id` to the pixels of `box` that the moved outline holds more deeply than what holds them so far.
void add_mask(const cv::Mat& ids, int id, const cv::Rect& box, const cv::Mat& displacement_px,
              cv::Mat& depth_px, cv::Mat& masks) {
  cv::Mat inside;
  cv::compare(ids(box), id, inside, cv::CMP_EQ);
  const cv::Mat moved = signed_distance(inside) + displacement_px;
  cv::Mat held = depth_px(box);
  const cv::Mat wins = moved > held;
  moved.copyTo(held, wins);
  masks(box).setTo(id, wins);
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
  const int margin = static_cast<int>(std::ceil(kReach_sigmas * noise.boundary_sigma_px)) + 1;
  for (const auto& [id, mask] : find_masks(ids)) {
    RandomStream miss(seed, "segmenter_miss", static_cast<std::uint64_t>(frame),
                      static_cast<std::uint32_t>(id));
    if (mask.pixels < noise.min_pixels || miss.uniform() < noise.miss_probability) continue;
    const cv::Rect wide(mask.box.x - margin, mask.box.y - margin, mask.box.width + 2 * margin,
                        mask.box.height + 2 * margin);
    const cv::Rect box = wide & cv::Rect({0, 0}, ids.size());
    const cv::Mat field = smooth_field(box.size(), noise.boundary_length_px, seed, frame, id);
    add_mask(ids, id, box, noise.boundary_sigma_px * field, depth_px, masks);
  }
  return masks;
}

}  // namespace uniquadric
