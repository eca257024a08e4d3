#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "core/sequence/sequence.h"
#include "estimator/segmentation/segmentation.h"

namespace uniquadric {

/// A segmenter as the tracker runs it: slow, one frame at a time.
struct SlowSegmenter {
  /// Masks (CV_16UC1, a value a body, 0 none) of a frame; an empty image where it cannot say.
  std::function<cv::Mat(const SegmenterInput&)> segment;
  /// How long it takes for a frame; nothing: it has none for this frame.
  std::function<std::optional<std::int64_t>(const SequenceFrame&)> latency_ns;
};

/// Masks of an earlier frame (the keyframe), there now.
struct SegmenterResult {
  std::int64_t frame = 0;
  cv::Mat masks;
};

/// Runs a segmenter beside the frames: it takes the newest frame whenever it is free, and its result comes a
/// latency later.
class SegmenterClock {
 public:
  virtual ~SegmenterClock() = default;
  /// Offers the next frame and returns the results that have arrived by its time, and its own if that comes
  /// before `next_ns`, when the frame after it does: there is time for it.
  virtual std::vector<SegmenterResult> step(const SegmenterInput& input, std::int64_t next_ns) = 0;
  std::vector<SegmenterResult> step(const SegmenterInput& input) { return step(input, input.frame.stamp_ns); }
  /// The oldest frame whose result may still come.
  virtual std::int64_t oldest_pending() const = 0;
};

/// Time is that of the frames' stamps: the same frames give the same results.
std::unique_ptr<SegmenterClock> make_virtual_clock(SlowSegmenter segmenter);

/// Time is the machine's: the segmenter runs in a thread of its own, and its result comes when it is done
/// (but not before its latency has passed). What a frame's masks are then depends on the machine. An
/// exception of the segmenter is rethrown by step().
std::unique_ptr<SegmenterClock> make_thread_clock(SlowSegmenter segmenter);

}  // namespace uniquadric
