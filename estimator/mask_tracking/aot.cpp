#include "estimator/mask_tracking/aot.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <opencv2/core.hpp>
#include <set>

#include "estimator/mask_tracking/clear_body.h"
#include "estimator/observation/outline.h"

namespace uniquadric {
namespace {

constexpr double kNanosecond_s = 1e-9;
constexpr double kSpeckShare = 0.02;  // of the largest part; others may be the body behind a pole

// The masks of those ids that `keeps`.
cv::Mat select_ids(const cv::Mat& masks, const std::function<bool(int)>& keeps) {
  std::vector<char> is_kept(1 << 16, -1);  // unknown
  cv::Mat selected = masks.clone();
  for (auto& id : cv::Mat_<std::uint16_t>(selected)) {
    if (id == 0) continue;
    char& kept = is_kept[id];
    if (kept < 0) kept = keeps(id);
    if (!kept) id = 0;
  }
  return selected;
}

// The ids whose masks overlap with `iou` or more in both images.
std::set<int> ids_that_agree(const cv::Mat& a, const cv::Mat& b, double iou) {
  struct Counts {
    int both = 0, either = 0;
  };
  std::map<int, Counts> counts;
  for (int v = 0; v < a.rows; ++v) {
    const auto *row_a = a.ptr<std::uint16_t>(v), *row_b = b.ptr<std::uint16_t>(v);
    for (int u = 0; u < a.cols; ++u) {
      if ((row_a[u] | row_b[u]) == 0) continue;
      if (row_a[u] == row_b[u]) ++counts[row_a[u]].both;
      if (row_a[u]) ++counts[row_a[u]].either;
      if (row_b[u] && row_b[u] != row_a[u]) ++counts[row_b[u]].either;
    }
  }
  std::set<int> ids;
  for (const auto& [id, c] : counts)
    if (c.both >= iou * c.either) ids.insert(id);
  return ids;
}

std::unique_ptr<MaskTracker> make_mask_tracker(const AotOptions& options) {
  if (options.tracker == MaskTrackerKind::nanotrack) return std::make_unique<NanoTracker>(options.nano);
  return std::make_unique<FlowTracker>(options.flow);
}

cv::Mat relabelled(const std::vector<Detection>& detections, const std::map<int, int>& ids, cv::Size size) {
  cv::Mat masks = cv::Mat::zeros(size, CV_16UC1);
  for (const auto& detection : detections)
    if (const auto id = ids.find(detection.label); id != ids.end())
      masks(detection.region).setTo(id->second, detection.mask);
  return masks;
}

}  // namespace

AsyncObjectTracker::AsyncObjectTracker(const Camera& camera, SlowSegmenter segmenter,
                                       const AotOptions& options)
    : camera_(camera),
      options_(options),
      clock_(options.clock == AotClock::threads ? make_thread_clock(std::move(segmenter))
                                                : make_virtual_clock(std::move(segmenter))),
      tracker_(make_mask_tracker(options)) {}

std::vector<Detection> AsyncObjectTracker::detect(const Seen& seen, const cv::Mat& masks) const {
  std::vector<Detection> detections;
  if (masks.empty()) return detections;
  for (const auto& [label, region] : mask_regions(masks, options_.min_pixels, kSpeckShare))
    detections.push_back({label, region.box, region.mask,
                          appearance_of(region.mask, region.box, seen.image.rgb, seen.image.depth, camera_)});
  return detections;
}

// Backward association: the result is named at its own frame.
void AsyncObjectTracker::associate(const SegmenterResult& result, AotFrame& out) {
  const auto seen =
      std::find_if(seen_.begin(), seen_.end(), [&](const Seen& s) { return s.frame.frame == result.frame; });
  if (seen == seen_.end() || result.masks.empty()) return;
  last_arrival_ns_ = seen_.back().frame.stamp_ns;
  const std::int64_t stamp_ns = seen->frame.stamp_ns;
  const auto detections = detect(*seen, result.masks);
  const auto ids = options_.trust_ids ? book_.trust(detections, stamp_ns)
                                      : book_.associate(detections, seen->masks, stamp_ns);
  const cv::Mat named = relabelled(detections, ids, seen->masks.size());
  const cv::Mat masks =
      fit_to_edges(named, {seen->image.rgb, seen->image.depth, expected_depth(named, *seen)}, options_.edges);
  if (options_.clear_growth > 0 && !seen->image.depth.empty())
    for (const auto& [id, area_m2] : mask_areas_m2(masks, seen->image.depth, camera_))
      areas_m2_[id] = std::max(areas_m2_[id], area_m2);
  tracker_->learn(masks, seen->image);
  jump(masks, seen - seen_.begin());
  out.arrived.push_back({result.frame, masks, seen->image.depth});
}

// The depth of a frame where what was tracked and what was segmented agree on the body.
cv::Mat AsyncObjectTracker::expected_depth(const cv::Mat& named, const Seen& seen) {
  if (seen.image.depth.empty()) return {};
  cv::Mat expected = cv::Mat::zeros(named.size(), CV_32FC1);
  seen.image.depth.copyTo(expected, (named == seen.masks) & (named != 0));
  return expected;
}

// Jump track: masks of an earlier frame are carried to the newest and take the place of what was tracked
// there, but for bodies whose masks agreed then. Bodies that the result does not show stay for a while: it
// may have missed them.
void AsyncObjectTracker::jump(const cv::Mat& masks, std::size_t index) {
  const std::set<int> agreeing = ids_that_agree(masks, seen_[index].masks, options_.jump_iou);
  const auto& tracks = book_.tracks();
  const auto stays = [&](int id) {
    const auto track = tracks.find(id);
    if (track == tracks.end()) return false;
    return agreeing.contains(id) ||
           (track->second.missing > 0 && track->second.missing < options_.max_missing);
  };
  const cv::Mat anew = select_ids(masks, [&](int id) { return !agreeing.contains(id); });
  cv::Mat newest = select_ids(seen_.back().masks, stays);
  cv::Mat carried = anew;
  for (std::size_t next = index + 1; next < seen_.size(); ++next) {
    if (!is_near(seen_[next - 1], seen_[next])) return;
    if (cv::countNonZero(anew) > 0) carried = carry(carried, seen_[next - 1], seen_[next]);
  }
  seen_.back().has_masks = true;
  carried.copyTo(newest, carried != 0);
  seen_.back().masks = newest;
}

// Whether masks can be carried from one frame to another.
bool AsyncObjectTracker::is_near(const Seen& from, const Seen& to) const {
  return kNanosecond_s * static_cast<double>(to.frame.stamp_ns - from.frame.stamp_ns) <= options_.max_gap_s;
}

cv::Mat AsyncObjectTracker::carry(const cv::Mat& masks, const Seen& from, const Seen& to) const {
  CarriedMasks carried = tracker_->carry(masks, from.image, to.image);
  if (options_.clear_growth > 0)
    carried.masks = fit_to_clear_bodies(carried.masks, to.image.depth, camera_, areas_m2_,
                                        options_.edges.jump, options_.clear_growth);
  const cv::Mat fitted =
      fit_to_edges(carried.masks, {to.image.rgb, to.image.depth, carried.expected_depth}, options_.edges);
  cv::Mat clean = cv::Mat::zeros(masks.size(), CV_16UC1);
  for (const auto& [id, region] : mask_regions(fitted, options_.min_pixels, kSpeckShare))
    clean(region.box).setTo(id, region.mask);
  return clean;
}

AotFrame AsyncObjectTracker::track(const SequenceFrame& frame, const cv::Mat& rgb, const cv::Mat& depth,
                                   std::int64_t next_ns) {
  AotFrame out;
  Stopwatch watch(frame.frame, out.times);
  seen_.push_back({frame, {frame.frame, rgb, depth, {}, {}}, cv::Mat::zeros(rgb.size(), CV_16UC1)});
  Seen& newest = seen_.back();
  const Seen* previous = seen_.size() > 1 ? &seen_[seen_.size() - 2] : nullptr;
  tracker_->prepare(newest.image, previous ? &previous->image : nullptr);
  watch.stop("mask_flow");
  const double silence_s =
      last_arrival_ns_ ? kNanosecond_s * static_cast<double>(frame.stamp_ns - *last_arrival_ns_) : 0;
  newest.has_masks =
      previous && previous->has_masks && silence_s <= options_.max_silence_s && is_near(*previous, newest);
  if (newest.has_masks) newest.masks = carry(previous->masks, *previous, newest);
  watch.stop("mask_tracker");
  const auto results = clock_->step({frame, rgb, depth, newest.masks.clone()}, next_ns);
  watch.stop("segmenter");
  for (const auto& result : results) associate(result, out);
  watch.stop("association");
  out.masks = newest.masks.clone();
  out.has_masks = newest.has_masks;
  out.oldest_pending = clock_->oldest_pending();
  while (seen_.size() > 1 && seen_.front().frame.frame < out.oldest_pending) seen_.pop_front();
  return out;
}

SlowSegmenter slow_segmenter(const Sequence& sequence, PromptedSegmenter segmenter, const AotOptions& options,
                             std::uint64_t seed) {
  const bool is_simulated = segmenter.source == kSequenceMasks;
  const auto fixed_ns = static_cast<std::int64_t>(std::llround(options.latency_s * 1e9));
  const bool is_prompted = segmenter.prompt_kind != PromptKind::everything;
  const bool is_fixed = options.latency == AotLatency::fixed || (!is_simulated && !is_prompted);
  SlowSegmenter slow;
  slow.latency_ns = [=](const SequenceFrame& frame) -> std::optional<std::int64_t> {
    if (is_simulated && frame.masks.empty()) return std::nullopt;
    if (is_fixed) return fixed_ns;
    return is_simulated ? frame.masks_arrival_ns - frame.stamp_ns : 0;
  };
  slow.segment = [&sequence, segmenter = std::move(segmenter), seed](const SegmenterInput& input) {
    return segment(segmenter, sequence, input, seed);
  };
  return slow;
}

}  // namespace uniquadric
