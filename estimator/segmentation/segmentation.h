#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <set>
#include <vector>

#include "core/sequence/sequence.h"
#include "estimator/segmentation/box_detector.h"
#include "estimator/segmentation/depth_parts.h"
#include "estimator/segmentation/grabcut_depth.h"
#include "estimator/segmentation/motion_split.h"
#include "estimator/segmentation/prompt_watch.h"
#include "estimator/segmentation/prompts.h"
#include "estimator/segmentation/sam_segmenter.h"

namespace uniquadric {

enum class MaskSource {
  automatic,  ///< the sequence's own masks where it has some, else grabcut_depth for boxes, else depth_motion
  sequence,   ///< masks/ of the sequence: the simulated segmenter; prompts select among its bodies
  grabcut_depth,  ///< box prompts, GrabCut and depth
  depth_motion,  ///< parts of the depth image off its planes, split by motion: everything, or those at points
  sam,           ///< a SAM-style encoder and decoder (ONNX): everything, points or boxes
  detector,      ///< a YOLOX detector (ONNX) whose boxes go to grabcut_depth: everything
  none,          ///< no objects: all is background
};

struct SegmentationOptions {
  MaskSource source = MaskSource::automatic;
  GrabcutOptions grabcut_depth;
  DepthPartsOptions depth_parts;
  MotionSplitOptions motion_split;
  SamOptions sam;
  DetectorOptions detector;
};

/// Where the masks of a sequence come from, with all that is read once. Copies share the networks.
struct Segmenter {
  MaskSource source = MaskSource::sequence;  ///< never automatic
  SegmentationOptions options;
  PromptKind prompt_kind = PromptKind::everything;
  bool names_bodies = false;  ///< the prompts' own ids tell one body from another over the frames
  std::vector<std::vector<BoxPrompt>> boxes;     ///< of each frame; empty without box prompts
  std::vector<std::vector<PointPrompt>> points;  ///< of each frame; empty without point prompts
  std::optional<std::set<int>> selected;  ///< ids of the sequence's masks that a prompt means; nothing: all
  std::shared_ptr<PromptWatch> watch;     ///< of prompts
  std::shared_ptr<const SamSegmenter> sam;
  std::optional<OnnxModel> detector;
};

/// Resolves the source, reads the prompts and loads the networks. With the sequence's masks, boxes select the
/// ids whose masks they fit in any frame, points those that they lie on (two that lie on one are said on
/// stderr, here and by segment()). Throws InputError for sources that
/// the sequence does not have, for prompts that a source does not take, for prompts that fit no mask, and for
/// networks that OpenCV refuses.
Segmenter make_segmenter(const Sequence& sequence, const SegmentationOptions& options,
                         const Prompts& prompts);

/// Whether a segmenter may find something in a frame by itself: it has masks, prompts, or needs none.
bool has_something_for(const Segmenter& segmenter, const SequenceFrame& frame);

/// A frame as a segmenter sees it.
struct SegmenterInput {
  SequenceFrame frame;
  cv::Mat rgb;      ///< CV_8UC3; may be empty for the sequence's own masks
  cv::Mat depth;    ///< CV_32FC1 [m], 0 none
  cv::Mat tracked;  ///< CV_16UC1: masks carried from earlier frames, may be empty; their bodies are prompts
                    ///< where the user gives none for them in this frame
};

/// Object ids of a frame's pixels (CV_16UC1, 0 background); an empty image where there is nothing to go by. A
/// mask counts for its own frame, whenever it arrived. Ids are those of the prompts or of the sequence's
/// masks, and otherwise mean nothing beyond the frame.
cv::Mat segment(const Segmenter& segmenter, const Sequence& sequence, const SegmenterInput& input,
                std::uint64_t seed);
/// The same without a tracker; reads the frame's colours where they are needed.
cv::Mat segment(const Segmenter& segmenter, const Sequence& sequence, const SequenceFrame& frame,
                const cv::Mat& depth, std::uint64_t seed);

}  // namespace uniquadric
