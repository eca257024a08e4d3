#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "core/sequence/sequence.h"
#include "estimator/base/stopwatch.h"
#include "estimator/mask_tracking/flow_tracker.h"
#include "estimator/mask_tracking/mask_edges.h"
#include "estimator/mask_tracking/nano_tracker.h"
#include "estimator/mask_tracking/track_association.h"
#include "estimator/segmentation/segmentation.h"
#include "estimator/segmentation/segmenter_clock.h"

namespace uniquadric {

enum class AotClock {
  virtual_time,  ///< of the frames' stamps; deterministic
  threads,       ///< the machine's: what arrives when depends on its speed
};

/// What carries masks from frame to frame.
enum class MaskTrackerKind {
  flow,       ///< dense optical flow
  nanotrack,  ///< boxes by NanoTrack (ONNX)
};

/// How long the segmenter takes.
enum class AotLatency {
  sequence,  ///< what the sequence says (masks.txt) of the simulated segmenter; none of prompts; else
             ///< latency_s
  fixed,     ///< latency_s
};

/// The asynchronous object tracker.
struct AotOptions {
  bool enabled = true;  // off: the segmenter's masks count at their own frames, as if it took no time
  AotClock clock = AotClock::virtual_time;
  AotLatency latency = AotLatency::sequence;
  double latency_s =
      0.1;  // ours: of AotLatency::fixed, and of segmenters without prompts whose latency no file says
  MaskTrackerKind tracker = MaskTrackerKind::flow;
  FlowTrackerOptions flow;
  NanoTrackOptions nano;
  MaskEdgeOptions edges;
  double clear_growth = 1.2;  // ours: of the largest area that a segmenter gave a body (clear_body.h); 0: off
  bool trust_ids = false;     // ours: the segmenter's own ids are the tracks'; only a simulated one has any
  int min_pixels = 50;        // ours: smaller masks are not kept
  static constexpr double jump_iou =
      0.985;  // ours: a body whose new mask agrees so well with the tracked one is not carried anew
  static constexpr int max_missing = 2;  // ours: results without a body after which its carried mask is given
                                         // up: one in a hundred is missed by chance
  double max_silence_s = 5;              // ours: without any result; then carried masks are given up
  double max_gap_s = 0.3;  // ours: between frames; flow finds nothing over more, and masks are not carried
};

/// What is known when a frame has been taken.
struct AotFrame {
  cv::Mat masks;  ///< CV_16UC1 track ids, 0 none: of this frame, carried from the last segmented ones
  bool has_masks =
      false;  ///< whether they are known: none may mean that nothing is in view, or no result yet
  /// A segmenter's result that arrived with this frame, of its own, earlier frame, named by track ids.
  struct Arrived {
    std::int64_t frame = 0;
    cv::Mat masks, depth;  ///< depth: of that frame, as it was given
  };
  std::vector<Arrived> arrived;
  std::int64_t oldest_pending = 0;  ///< the oldest frame whose result may still come
  std::vector<StageTime> times;     ///< mask_flow, mask_tracker, segmenter, association
};

/// The paper's Asynchronous Object Tracker: a slow segmenter looks at keyframes, a mask tracker carries masks
/// every frame. When the result for keyframe k arrives at frame n, *backward association* names its masks by
/// the tracker's masks of frame k, and *jump track* carries them from k to n at once.
class AsyncObjectTracker {
 public:
  AsyncObjectTracker(const Camera& camera, SlowSegmenter segmenter, const AotOptions& options);

  /// Takes the next frame; frames come in order. `rgb` CV_8UC3, `depth` CV_32FC1 [m], 0 none; may be empty.
  /// The images are kept for a while: they must not be written to. `next_ns`: when the frame after it comes;
  /// a result for this frame that is there before counts at once.
  AotFrame track(const SequenceFrame& frame, const cv::Mat& rgb, const cv::Mat& depth, std::int64_t next_ns);
  AotFrame track(const SequenceFrame& frame, const cv::Mat& rgb, const cv::Mat& depth) {
    return track(frame, rgb, depth, frame.stamp_ns);
  }

 private:
  struct Seen {
    SequenceFrame frame;
    TrackedImage image;
    cv::Mat masks;  // as they were tracked
    bool has_masks = false;
  };
  std::vector<Detection> detect(const Seen& seen, const cv::Mat& masks) const;
  bool is_near(const Seen& from, const Seen& to) const;
  static cv::Mat expected_depth(const cv::Mat& named, const Seen& seen);
  void associate(const SegmenterResult& result, AotFrame& out);
  void jump(const cv::Mat& masks, std::size_t index);
  cv::Mat carry(const cv::Mat& masks, const Seen& from, const Seen& to) const;

  Camera camera_;
  AotOptions options_;
  std::unique_ptr<SegmenterClock> clock_;
  std::unique_ptr<MaskTracker> tracker_;
  TrackBook book_;
  std::map<int, double> areas_m2_;  // of the bodies, the largest that the segmenter's masks had
  std::deque<Seen> seen_;           // from the oldest frame whose result may still come to the newest
  std::optional<std::int64_t> last_arrival_ns_;
};

/// A segmenter of a sequence as the tracker runs it. `sequence` must stay alive; frames without a mask of a
/// simulated segmenter take no time, it never looked at them.
SlowSegmenter slow_segmenter(const Sequence& sequence, PromptedSegmenter segmenter, const AotOptions& options,
                             std::uint64_t seed);

}  // namespace uniquadric
