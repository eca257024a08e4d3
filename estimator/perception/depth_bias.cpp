#include "estimator/perception/depth_bias.h"

#include <cmath>
#include <vector>

#include "core/base/quantile.h"
#include "core/base/seconds.h"

namespace uniquadric {
namespace {

constexpr double kLongest_s = 10;
constexpr std::size_t kFirstFrames = 30;  // before the first adjustment; then after twice as many
constexpr double kEnough = 3e-4;          // of depth: what a sigma of the bias may do to it

double usual_depth_m(const EgoMap& map) {
  std::vector<double> depths;
  for (const Keyframe& keyframe : map.keyframes)
    for (const Feature& feature : keyframe.features)
      if (feature.depth_m > 0) depths.push_back(feature.depth_m);
  return depths.empty() ? 1 : quantile(std::move(depths), 0.5);
}

}  // namespace

DepthBias depth_bias(const Sequence& sequence, FeatureOptions options, const EgoOptions& ego,
                     std::uint64_t seed) {
  options.body_features = 0;
  FeatureTracker features(sequence.camera, options, seed, sequence.rolling_shutter_s);
  RgbdOdometry odometry(sequence.camera, ego, seed, 0,
                        options.rolling_shutter.enabled ? sequence.rolling_shutter_s : 0);
  DepthBias known;
  std::size_t next = kFirstFrames;
  for (std::size_t i = 0; i < sequence.frames.size(); ++i) {
    const SequenceFrame& frame = sequence.frames[i];
    if (frame.depth.empty()) continue;
    const cv::Mat depth = read_depth(sequence, frame);
    const cv::Mat masks =
        frame.masks.empty() ? cv::Mat(cv::Mat::zeros(depth.size(), CV_16UC1)) : read_masks(sequence, frame);
    odometry.track(frame, features.track(frame, read_rgb(sequence, frame), depth, masks, {}), depth, masks);
    const bool is_last = i + 1 == sequence.frames.size() ||
                         seconds(sequence.frames.front().stamp_ns, frame.stamp_ns) > kLongest_s;
    if (!is_last && i + 1 < next) continue;
    next *= 2;
    if (const auto bias =
            calibrate_depth(odometry.map(), without_distortion(sequence.camera), ego.bundle.pixel_sigma))
      known = *bias;
    if (is_last || (known.sigma_per_m > 0 && known.sigma_per_m * usual_depth_m(odometry.map()) < kEnough))
      break;
  }
  return known;
}

}  // namespace uniquadric
