#include "estimator/mask_tracking/nano_tracker.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/dnn.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"
#include "estimator/observation/outline.h"

namespace uniquadric {
namespace {

constexpr int kTemplate_px = 127, kSearch_px = 255, kStride_px = 16;

// Side of the square that shows a box with its surroundings.
double context_side(const Eigen::Vector2d& size) {
  const double margin = size.sum() / 2;
  return std::sqrt((size.x() + margin) * (size.y() + margin));
}

// The square around a point, scaled; beyond the image it is its mean colour.
cv::Mat crop(const cv::Mat& rgb, const Eigen::Vector2d& center, double side, int size_px) {
  const double scale = size_px / side, middle = (size_px - 1) / 2.0;
  const cv::Matx23d to_crop(scale, 0, middle - scale * center.x(), 0, scale, middle - scale * center.y());
  cv::Mat result;
  cv::warpAffine(rgb, result, to_crop, {size_px, size_px}, cv::INTER_LINEAR, cv::BORDER_CONSTANT,
                 cv::mean(rgb));
  return result;
}

double hanning(int i, int n) {
  return 0.5 * (1 - std::cos(2 * std::numbers::pi * i / (n - 1)));
}

double growth(double ratio) {
  return std::max(ratio, 1 / ratio);
}

// How alike the sizes and proportions of two boxes are: 1 for equal ones.
double size_likeness(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double penalty) {
  const double size = growth(context_side(a) / context_side(b));
  const double proportion = growth((a.x() / a.y()) / (b.x() / b.y()));
  return std::exp(-(size * proportion - 1) * penalty);
}

NanoBox box_of(const cv::Rect& rect) {
  return {{rect.x + (rect.width - 1) / 2.0, rect.y + (rect.height - 1) / 2.0},
          {static_cast<double>(rect.width), static_cast<double>(rect.height)}};
}

// From a pixel of the new image to where it was, for a box that moved and grew.
cv::Matx23d back_to(const NanoBox& before, const NanoBox& now) {
  const double sx = before.size.x() / now.size.x(), sy = before.size.y() / now.size.y();
  return {sx, 0, before.center.x() - sx * now.center.x(), 0, sy, before.center.y() - sy * now.center.y()};
}

}  // namespace

std::optional<NanoBox> decode_nanotrack(const cv::Mat& scores, const cv::Mat& sides, const NanoBox& previous,
                                        double scale, const NanoTrackOptions& options) {
  const int n = scores.size[2];
  double best = -1, best_likeness = 0, best_probability = 0;
  NanoBox found;
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      const auto score = [&](int channel) { return scores.ptr<float>(0, channel)[y * n + x]; };
      const auto side = [&](int channel) {
        return static_cast<double>(sides.ptr<float>(0, channel)[y * n + x]);
      };
      const Eigen::Vector2d cell((x - n / 2) * kStride_px,
                                 (y - n / 2) * kStride_px);  // from the window's middle
      const Eigen::Vector2d size(side(0) + side(2), side(1) + side(3));
      if (!(size.minCoeff() > 0)) continue;
      const double probability = 1 / (1 + std::exp(score(0) - score(1)));
      const double likeness = size_likeness(size, previous.size * scale, options.size_penalty);
      const double value = probability * likeness * (1 - options.window_influence) +
                           hanning(x, n) * hanning(y, n) * options.window_influence;
      if (value <= best) continue;
      best = value, best_likeness = likeness, best_probability = probability;
      found.center =
          previous.center + (cell + Eigen::Vector2d(side(2) - side(0), side(3) - side(1)) / 2) / scale;
      found.size = size / scale;
    }
  if (best_probability < options.min_score) return std::nullopt;
  const double rate = best_likeness * best_probability * options.learning_rate;
  found.size = rate * found.size + (1 - rate) * previous.size;
  return found;
}

NanoTracker::NanoTracker(const NanoTrackOptions& options)
    : options_(options), backbone_(options.backbone), head_(options.head) {}

cv::Mat NanoTracker::features(const cv::Mat& crop_image) const {
  const cv::Mat blob = cv::dnn::blobFromImage(crop_image, 1, {}, {}, true);
  return backbone_.run({{"", blob}}, backbone_.output_names()).front();
}

void NanoTracker::learn(const cv::Mat& masks, const TrackedImage& image) {
  for (const auto& [id, rect] : id_boxes(masks)) {
    const NanoBox box = box_of(rect);
    templates_[id] = features(crop(image.rgb, box.center, context_side(box.size), kTemplate_px));
  }
}

NanoBox NanoTracker::find(const cv::Mat& template_features, const NanoBox& previous,
                          const cv::Mat& rgb) const {
  const double scale = kTemplate_px / context_side(previous.size);
  const cv::Mat search = features(crop(rgb, previous.center, kSearch_px / scale, kSearch_px));
  const auto outputs = head_.run({{"input1", template_features}, {"input2", search}}, {"output1", "output2"});
  const auto is_map = [&](const cv::Mat& map, int channels) {
    return map.dims == 4 && map.size[1] == channels && map.size[2] == map.size[3] &&
           map.size[2] == outputs[0].size[2];
  };
  if (!is_map(outputs[0], 2) || !is_map(outputs[1], 4))
    throw InputError(head_.file(), "is no head of NanoTrack's form: 2 scores and 4 sides a cell");
  return decode_nanotrack(outputs[0], outputs[1], previous, scale, options_).value_or(previous);
}

CarriedMasks NanoTracker::carry(const cv::Mat& masks, const TrackedImage& from,
                                const TrackedImage& to) const {
  CarriedMasks carried{cv::Mat::zeros(masks.size(), CV_16UC1), {}};
  if (!from.depth.empty()) carried.expected_depth = cv::Mat::zeros(masks.size(), CV_32FC1);
  for (const auto& [id, rect] : id_boxes(masks)) {
    const auto known = templates_.find(id);
    if (known == templates_.end()) continue;
    const NanoBox before = box_of(rect), now = find(known->second, before, to.rgb);
    const cv::Matx23d origin = back_to(before, now);
    const auto moved = [&](const cv::Mat& image, int interpolation) {
      cv::Mat result;
      cv::warpAffine(image, result, origin, image.size(), interpolation | cv::WARP_INVERSE_MAP);
      return result;
    };
    const cv::Mat mask = moved(masks == id, cv::INTER_LINEAR) > 127;
    carried.masks.setTo(id, mask);
    if (!from.depth.empty()) moved(from.depth, cv::INTER_NEAREST).copyTo(carried.expected_depth, mask);
  }
  return carried;
}

}  // namespace uniquadric
