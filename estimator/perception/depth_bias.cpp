#include "estimator/perception/depth_bias.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "core/base/progress.h"
#include "core/base/quantile.h"
#include "core/base/seconds.h"
#include "core/sequence/smeared_edges.h"
#include "estimator/perception/frame_pipeline.h"
#include "estimator/shape/even_choice.h"

namespace uniquadric {
namespace {

constexpr double kLongest_s = 10;
constexpr int kFirstImages = 30;  // of depth, before the first adjustment; then after twice as many
constexpr int kEdgeImages = 20;
constexpr double kEnough =
    5e-4;  // of depth: what a sigma of the bias may do to it. Ours: as far as noise lets it

std::span<const SequenceFrame> frames_to_use(const Sequence& sequence) {
  const auto& frames = sequence.frames;
  const auto end = std::find_if(frames.begin(), frames.end(), [&](const SequenceFrame& frame) {
    return seconds(frames.front().stamp_ns, frame.stamp_ns) > kLongest_s;
  });
  return {frames.begin(), end};
}

struct Images {
  const SequenceFrame* frame;
  cv::Mat rgb, depth, masks;
  TrackedFeatures features;
};

double usual_depth_m(const EgoMap& map) {
  std::vector<double> depths;
  for (const Keyframe& keyframe : map.keyframes)
    for (const Feature& feature : keyframe.features)
      if (feature.depth_m > 0) depths.push_back(feature.depth_m);
  return depths.empty() ? 1 : quantile(std::move(depths), 0.5);
}

}  // namespace

std::optional<DepthBias> depth_bias(const Sequence& sequence, const PerceptionOptions& options,
                                    bool has_masks, const PerceiveOptions& run) {
  FeatureOptions own = options.features;
  own.body_features = 0;
  FeatureTracker features(sequence.camera, own, run.seed, sequence.rolling_shutter_s);
  RgbdOdometry odometry(sequence.camera, options.odometry, run.seed, 0,
                        own.rolling_shutter.enabled ? sequence.rolling_shutter_s : 0);
  DepthCheck check(options.depth_check);
  std::optional<DepthBias> found;
  const auto first_frames = frames_to_use(sequence);
  Progress progress("calibrate", std::ssize(first_frames), run.quiet);
  int images = 0, next = kFirstImages;
  std::atomic<bool> is_enough = false;
  auto at = first_frames.begin();
  const auto take = [&]() -> std::shared_ptr<Images> {
    if (at == first_frames.end() || is_enough) return nullptr;
    return std::make_shared<Images>(Images{&*at++, {}, {}, {}, {}});
  };
  const auto read = [&](Images& now) {
    now.rgb = read_rgb(sequence, *now.frame);
    if (!now.frame->depth.empty()) now.depth = read_depth(sequence, *now.frame);
    if (has_masks && !now.frame->masks.empty())
      now.masks = read_masks(sequence, *now.frame);
    else
      now.masks = cv::Mat::zeros(sequence.camera.height, sequence.camera.width, CV_16UC1);
  };
  const auto follow = [&](Images& now) {
    if (is_enough) return;
    if (!now.depth.empty() && !check.is_measurement(now.frame->stamp_ns, now.depth)) now.depth.setTo(0);
    now.features = features.track(*now.frame, now.rgb, now.depth, now.masks, {});
  };
  const auto place = [&](const Images& now) {
    if (is_enough) return;  // one that was on its way
    odometry.track(*now.frame, now.features, now.depth, now.masks);
    progress.advance();
    images += !now.depth.empty();
    const bool is_last = now.frame == &first_frames.back();
    if (images < next && !is_last) return;
    next *= 2;
    const double enough = kEnough / usual_depth_m(odometry.map());
    found = calibrate_depth(odometry.map(), without_distortion(sequence.camera),
                            options.odometry.bundle.pixel_sigma,
                            is_last ? std::numeric_limits<double>::infinity() : enough);
    is_enough = found && found->sigma_per_m < enough;
  };
  using enum FrameOrder;
  pass_frames<Images>(run.threads, kFramesInFlight, take,
                      {{at_once, read}, {in_order, follow}, {in_order, place}});
  return found;
}

double depth_edge_width_px(const Sequence& sequence) {
  std::vector<const SequenceFrame*> frames;
  for (const SequenceFrame& frame : frames_to_use(sequence))
    if (!frame.depth.empty()) frames.push_back(&frame);
  std::vector<double> widths_px;
  for (const auto i : even_choice(std::ssize(frames), kEdgeImages))
    add_edge_widths(read_depth(sequence, *frames[static_cast<std::size_t>(i)]), widths_px);
  return usual_edge_width_px(std::move(widths_px));
}

}  // namespace uniquadric
