#include "simulator/noise/mask_faults.h"

#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <set>

#include "core/base/random.h"
#include "simulator/noise/true_masks.h"

namespace uniquadric {
namespace {

constexpr double kFault_s = 0.5;

class Faults {
 public:
  Faults(std::uint64_t seed, double time_s)
      : seed_(seed), period_(static_cast<std::uint64_t>(std::max(0.0, std::floor(time_s / kFault_s)))) {}

  RandomStream of(const char* name, int id) const {
    return {seed_, name, period_, static_cast<std::uint32_t>(id)};
  }

 private:
  std::uint64_t seed_, period_;
};

// Pairs (larger, smaller) of ids that stand beside each other.
std::set<std::pair<int, int>> touching(const cv::Mat& ids) {
  std::set<std::pair<int, int>> pairs;
  const auto look = [&](int a, int b) {
    if (a != b && a != 0 && b != 0) pairs.emplace(std::max(a, b), std::min(a, b));
  };
  for (int v = 0; v < ids.rows; ++v)
    for (int u = 0; u < ids.cols; ++u) {
      if (u > 0) look(ids.at<std::uint16_t>(v, u), ids.at<std::uint16_t>(v, u - 1));
      if (v > 0) look(ids.at<std::uint16_t>(v, u), ids.at<std::uint16_t>(v - 1, u));
    }
  return pairs;
}

void merge(cv::Mat& ids, const Faults& faults, double probability) {
  for (const auto& [larger, smaller] : touching(ids))
    if (faults.of("segmenter_merge", larger).uniform() < probability) ids.setTo(smaller, ids == larger);
}

void split(cv::Mat& ids, int id, RandomStream random) {
  const cv::Mat mask = ids == id;
  const cv::Moments moments = cv::moments(mask, true);
  const double angle = 2 * std::numbers::pi * random.uniform();
  const cv::Point2d normal(std::cos(angle), std::sin(angle));
  const cv::Point2d middle(moments.m10 / moments.m00, moments.m01 / moments.m00);
  for (int v = 0; v < ids.rows; ++v)
    for (int u = 0; u < ids.cols; ++u)
      if (mask.at<std::uint8_t>(v, u) && normal.dot(cv::Point2d(u, v) - middle) > 0)
        ids.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(kFirstFalseId + id % 2000);
}

void leak(cv::Mat& ids, int id, double leak_px) {
  const int reach = std::max(1, static_cast<int>(std::lround(leak_px)));
  cv::Mat grown;
  const cv::Mat column = cv::Mat::ones(reach + 1, 1, CV_8UC1);
  cv::dilate(ids == id, grown, column, {0, reach});  // a pixel looks at those above it
  ids.setTo(id, grown & (ids == 0));
}

void add_false_mask(cv::Mat& ids, RandomStream random) {
  const auto part = [&](double low, double high, int size) {
    return static_cast<int>(std::lround(random.uniform(low, high) * size));
  };
  const cv::Point middle(part(0, 1, ids.cols), part(0, 1, ids.rows));
  const cv::Size half(part(0.01, 0.05, ids.cols), part(0.01, 0.05, ids.cols));
  cv::Mat ellipse = cv::Mat::zeros(ids.size(), CV_8UC1);
  cv::ellipse(ellipse, middle, half, random.uniform(0, 180), 0, 360, 255, cv::FILLED);
  ids.setTo(kFirstFalseId + 5000, ellipse & (ids == 0));
}

}  // namespace

cv::Mat mask_faults(const cv::Mat& ids, const SegmenterNoise& noise, std::uint64_t seed, double time_s) {
  if (noise.merge_probability <= 0 && noise.split_probability <= 0 && noise.leak_probability <= 0 &&
      noise.false_probability <= 0)
    return ids;
  const Faults faults(seed, time_s);
  cv::Mat seen = ids.clone();
  if (noise.merge_probability > 0) merge(seen, faults, noise.merge_probability);
  for (const auto& [id, mask] : find_masks(seen)) {
    RandomStream random = faults.of("segmenter_fault", id);
    if (random.uniform() < noise.split_probability) split(seen, id, random);
    if (random.uniform() < noise.leak_probability) leak(seen, id, noise.leak_px);
  }
  RandomStream random = faults.of("segmenter_false", 0);
  if (random.uniform() < noise.false_probability) add_false_mask(seen, random);
  return seen;
}

}  // namespace uniquadric
