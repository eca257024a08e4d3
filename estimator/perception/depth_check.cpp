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

// Share of the pixels whose depth is that of an image before; nothing where none is near enough in time.
std::optional<double> agreement(const DepthRun& before, std::int64_t stamp_ns, const cv::Mat& thinned,
                                const DepthCheckOptions& options) {
  if (before.images == 0 || seconds(before.last_ns, stamp_ns) > options.max_gap_s) return std::nullopt;
  int both = 0, agreeing = 0;
  for (int v = 0; v < thinned.rows; ++v)
    for (int u = 0; u < thinned.cols; ++u) {
      const float now = thinned.at<float>(v, u), then = before.last.at<float>(v, u);
      if (!(now > 0 && then > 0)) continue;
      ++both;
      agreeing += std::abs(now - then) <= options.max_change * then;
    }
  if (both < kLeastPixels) return std::nullopt;
  return static_cast<double>(agreeing) / both;
}

void go_on(DepthRun& run, std::int64_t stamp_ns, const cv::Mat& thinned) {
  ++run.images;
  run.last_ns = stamp_ns;
  run.last = thinned;
}

}  // namespace

bool DepthCheck::is_measurement(std::int64_t stamp_ns, const cv::Mat& depth) {
  if (!options_.enabled) return true;
  const cv::Mat thinned = thinned_out(depth);
  const Values values = values_in(thinned);
  if (values.count < kLeastPixels) return true;
  const auto agreeing = agreement(believed_, stamp_ns, thinned, options_);
  // one value is a wall that is looked at straight where it was one before
  const bool fits = agreeing ? *agreeing >= options_.min_agreement : !values.all_same;
  if (!fits && (values.all_same || !outnumber(stamp_ns, thinned))) return false;
  if (!fits) believed_ = {};
  refused_ = {};
  go_on(believed_, stamp_ns, thinned);
  return true;
}

// Whether this image and the refused ones that it goes on from are more than those that were believed.
bool DepthCheck::outnumber(std::int64_t stamp_ns, const cv::Mat& thinned) {
  const auto agreeing = agreement(refused_, stamp_ns, thinned, options_);
  if (!agreeing || *agreeing < options_.min_agreement) refused_ = {};
  go_on(refused_, stamp_ns, thinned);
  return refused_.images > believed_.images;
}

}  // namespace uniquadric
