#include "estimator/perception/depth_check.h"

#include <cmath>

#include "core/base/seconds.h"

namespace uniquadric {
namespace {

constexpr int kStep_px = 4;       // between the pixels that are compared
constexpr int kLeastPixels = 50;  // to compare images by

cv::Mat thinned_out(const cv::Mat& depth) {
  cv::Mat thinned((depth.rows + kStep_px - 1) / kStep_px, (depth.cols + kStep_px - 1) / kStep_px, CV_32FC1);
  for (int v = 0; v < thinned.rows; ++v)
    for (int u = 0; u < thinned.cols; ++u)
      thinned.at<float>(v, u) = depth.at<float>(v * kStep_px, u * kStep_px);
  return thinned;
}

struct Values {
  int count = 0;
  bool all_same = true;
};

// Of the pixels that have depth.
Values values_in(const cv::Mat& depth) {
  Values values;
  float first = 0;
  for (int v = 0; v < depth.rows; ++v)
    for (int u = 0; u < depth.cols; ++u) {
      const float z = depth.at<float>(v, u);
      if (!(z > 0)) continue;
      if (values.count++ == 0) first = z;
      values.all_same &= z == first;
    }
  return values;
}

}  // namespace

// Share of the pixels whose depth is that of the last measurement; nothing where none is near enough in time.
std::optional<double> DepthCheck::agreement(std::int64_t stamp_ns, const cv::Mat& thinned) const {
  if (last_.empty() || seconds(last_ns_, stamp_ns) > options_.max_gap_s) return std::nullopt;
  int both = 0, agreeing = 0;
  for (int v = 0; v < thinned.rows; ++v)
    for (int u = 0; u < thinned.cols; ++u) {
      const float now = thinned.at<float>(v, u), before = last_.at<float>(v, u);
      if (!(now > 0 && before > 0)) continue;
      ++both;
      agreeing += std::abs(now - before) <= options_.max_change * before;
    }
  if (both < kLeastPixels) return std::nullopt;
  return static_cast<double>(agreeing) / both;
}

bool DepthCheck::is_measurement(std::int64_t stamp_ns, const cv::Mat& depth) {
  if (!options_.enabled) return true;
  const cv::Mat thinned = thinned_out(depth);
  const Values values = values_in(thinned);
  if (values.count < kLeastPixels) return true;
  const auto agreeing = agreement(stamp_ns, thinned);
  // one value is a wall that is looked at straight where it was one before
  if (agreeing ? *agreeing < options_.min_agreement : values.all_same) return false;
  last_ = thinned;
  last_ns_ = stamp_ns;
  return true;
}

}  // namespace uniquadric
