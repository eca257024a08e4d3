#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <set>
#include <vector>

#include "core/sequence/sequence.h"
#include "estimator/segmentation/prompt_watch.h"
#include "estimator/segmentation/segmenter.h"

namespace uniquadric {

/// Where the masks of a sequence come from, with all that is read once. Copies share the segmenter.
struct PromptedSegmenter {
  std::string source = kSequenceMasks;  ///< never automatic
  std::shared_ptr<const Segmenter> segmenter;
  PromptKind prompt_kind = PromptKind::everything;
  bool names_bodies = false;  ///< the prompts' own ids tell one body from another over the frames
  std::vector<std::vector<BoxPrompt>> boxes;     ///< of each frame; empty without box prompts
  std::vector<std::vector<PointPrompt>> points;  ///< of each frame; empty without point prompts
  std::optional<std::set<int>> selected;  ///< ids of the sequence's masks that a prompt means; nothing: all
  std::shared_ptr<PromptWatch> watch;     ///< of prompts
};

/// Resolves the source, reads the prompts and loads the networks. With the sequence's masks, boxes select the
/// ids whose masks they fit in any frame, points those that they lie on (two that lie on one are said on
/// stderr, here and by segment()). Throws InputError for sources that
/// the sequence does not have, for prompts that a source does not take, for prompts that fit no mask, and for
/// networks that OpenCV refuses.
PromptedSegmenter make_segmenter(const Sequence& sequence, const SegmentationOptions& options,
                                 const Prompts& prompts);

/// Warns of the prompts that led to no mask up to now.
void warn_of_prompts(const PromptedSegmenter& segmenter);

/// Whether a segmenter may find something in a frame by itself: it has masks, prompts, or needs none.
bool has_something_for(const PromptedSegmenter& segmenter, const SequenceFrame& frame);

/// Object ids of a frame's pixels (CV_16UC1, 0 background); an empty image where there is nothing to go by. A
/// mask counts for its own frame, whenever it arrived. Ids are those of the prompts or of the sequence's
/// masks, and otherwise mean nothing beyond the frame.
cv::Mat segment(const PromptedSegmenter& segmenter, const Sequence& sequence, const SegmenterInput& input,
                std::uint64_t seed);
/// The same without a tracker; reads the frame's colours where they are needed.
cv::Mat segment(const PromptedSegmenter& segmenter, const Sequence& sequence, const SequenceFrame& frame,
                const cv::Mat& depth, std::uint64_t seed);

}  // namespace uniquadric
