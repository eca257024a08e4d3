#include "simulator/noise/mask_faults.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "core/base/error.h"
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
  RandomStream of_pair(const char* name, int id, int other) const {  // each of 16 bits
    return {seed_, name, period_, static_cast<std::uint32_t>(id) << 16 | static_cast<std::uint32_t>(other)};
  }
  std::uint64_t period() const { return period_; }

 private:
  std::uint64_t seed_, period_;
};

// Pairs (larger, smaller) of ids that stand beside each other.
std::set<std::pair<int, int>> touching(const cv::Mat& ids) {
  std::set<std::pair<int, int>> pairs;
  const auto look = [&](int a, int b) {
    if (a != b && a != 0 && b != 0) pairs.emplace(std::max(a, b), std::min(a, b));
  };
  const auto look_along = [&](const std::uint16_t* row, const std::uint16_t* above, int count) {
    for (int u = 1; u < count; ++u) look(row[u], row[u - 1]);
    for (int u = 0; above && u < count; ++u) look(row[u], above[u]);
  };
  for (int v = 0; v < ids.rows; ++v)
    look_along(ids.ptr<std::uint16_t>(v), v > 0 ? ids.ptr<std::uint16_t>(v - 1) : nullptr, ids.cols);
  return pairs;
}

// Objects that are joined, directly or through others, are one object with the smallest id among them.
class Unions {
 public:
  void join(int a, int b) {
    const int one = label(a), other = label(b);
    if (one != other) smaller_[std::max(one, other)] = std::min(one, other);
  }
  int label(int id) const {
    for (auto found = smaller_.find(id); found != smaller_.end(); found = smaller_.find(id))
      id = found->second;
    return id;
  }
  bool empty() const { return smaller_.empty(); }

 private:
  std::map<int, int> smaller_;
};

void merge(cv::Mat& ids, const Faults& faults, double probability) {
  Unions unions;
  for (const auto& [larger, smaller] : touching(ids))
    if (faults.of_pair("segmenter_merge", larger, smaller).uniform() < probability)
      unions.join(larger, smaller);
  if (unions.empty()) return;
  for (const auto& [id, mask] : find_masks(ids))
    if (const int label = unions.label(id); label != id) {
      cv::Mat part = ids(mask.box);
      part.setTo(label, part == id);
    }
}

void split(cv::Mat& ids, int id, RandomStream& random, int part_id) {
  const cv::Mat mask = ids == id;
  const cv::Moments moments = cv::moments(mask, true);
  const double angle = 2 * std::numbers::pi * random.uniform();
  const cv::Point2d normal(std::cos(angle), std::sin(angle));
  const cv::Point2d middle(moments.m10 / moments.m00, moments.m01 / moments.m00);
  for (int v = 0; v < ids.rows; ++v)
    for (int u = 0; u < ids.cols; ++u)
      if (mask.at<std::uint8_t>(v, u) && normal.dot(cv::Point2d(u, v) - middle) > 0)
        ids.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(part_id);
}

void leak(cv::Mat& ids, int id, double leak_px) {
  const int reach = std::max(1, static_cast<int>(std::lround(leak_px)));
  cv::Mat grown;
  const cv::Mat column = cv::Mat::ones(reach + 1, 1, CV_8UC1);
  cv::dilate(ids == id, grown, column, {0, reach});  // a pixel looks at those above it
  ids.setTo(id, grown & (ids == 0));
}

void add_false_mask(cv::Mat& ids, RandomStream random, int false_id) {
  const auto part = [&](double low, double high, int size) {
    return static_cast<int>(std::lround(random.uniform(low, high) * size));
  };
  const int v = part(0, 1, ids.rows), u = part(0, 1, ids.cols);
  const int half_height = part(0.01, 0.05, ids.cols), half_width = part(0.01, 0.05, ids.cols);
  const double turn_deg = random.uniform(0, 180);
  cv::Mat ellipse = cv::Mat::zeros(ids.size(), CV_8UC1);
  cv::ellipse(ellipse, {u, v}, {half_width, half_height}, turn_deg, 0, 360, 255, cv::FILLED);
  ids.setTo(false_id, ellipse & (ids == 0));
}

}  // namespace

int false_id(const std::set<int>& objects, std::uint64_t period, int of_object) {
  constexpr int kMostId = 65535;
  std::vector<int> free;
  for (int id = kFirstFalseId; id <= kMostId; ++id)
    if (!objects.contains(id)) free.push_back(id);
  if (free.size() <= objects.size())
    throw InputError(fmt::format("segmenter: {} objects leave too few ids from {} on for false masks",
                                 objects.size(), kFirstFalseId));
  // a block of ids for each period: one for nothing, then one for each object
  const auto place = static_cast<std::uint64_t>(
      of_object == 0 ? 0 : 1 + std::distance(objects.begin(), objects.lower_bound(of_object)));
  return free[(period * (objects.size() + 1) + place) % free.size()];
}

cv::Mat mask_faults(const cv::Mat& ids, const SegmenterNoise& noise, std::uint64_t seed, double time_s,
                    const std::set<int>& objects) {
  if (noise.merge_probability <= 0 && noise.split_probability <= 0 && noise.leak_probability <= 0 &&
      noise.false_probability <= 0)
    return ids;
  const Faults faults(seed, time_s);
  cv::Mat seen = ids.clone();
  if (noise.merge_probability > 0) merge(seen, faults, noise.merge_probability);
  for (const auto& [id, mask] : find_masks(seen)) {
    RandomStream random = faults.of("segmenter_fault", id);
    if (random.uniform() < noise.split_probability)
      split(seen, id, random, false_id(objects, faults.period(), id));
    if (random.uniform() < noise.leak_probability) leak(seen, id, noise.leak_px);
  }
  RandomStream random = faults.of("segmenter_false", 0);
  if (random.uniform() < noise.false_probability)
    add_false_mask(seen, random, false_id(objects, faults.period(), 0));
  return seen;
}

}  // namespace uniquadric
