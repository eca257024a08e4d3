#pragma once

#include <cstdint>
#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <set>
#include <vector>

#include "core/sequence/sequence.h"
#include "estimator/perception/grabcut_depth.h"
#include "estimator/perception/prompts.h"

namespace uniquadric {

enum class MaskSource {
  automatic,      ///< the sequence's own masks where it has some, else grabcut_depth
  sequence,       ///< masks/ of the sequence
  grabcut_depth,  ///< box prompts, GrabCut and depth
};

struct SegmentationOptions {
  MaskSource source = MaskSource::automatic;
  GrabcutOptions grabcut_depth;
};

/// Where the masks of a sequence come from, with all that is read once.
struct Segmenter {
  MaskSource source = MaskSource::sequence;  ///< never automatic
  GrabcutOptions grabcut_depth;
  std::vector<std::vector<BoxPrompt>> prompts;  ///< of each frame; empty without prompts
  std::optional<std::set<int>> selected;  ///< ids of the sequence's masks that a prompt means; nothing: all
};

/// Resolves the source and reads the prompts (`prompts` empty: everything). With the sequence's masks, boxes
/// select the ids whose masks they fit in any frame. Throws InputError for sources that the sequence does not
/// have, for grabcut_depth without prompts and for prompts that fit no mask.
Segmenter make_segmenter(const Sequence& sequence, const SegmentationOptions& options,
                         const std::filesystem::path& prompts);

/// Object ids of a frame's pixels (CV_16UC1, 0 background); an empty image where there is nothing to go by. A
/// mask counts for its own frame, whenever it arrived. `depth` is the frame's (CV_32FC1, metres).
cv::Mat segment(const Segmenter& segmenter, const Sequence& sequence, const SequenceFrame& frame,
                const cv::Mat& rgb, const cv::Mat& depth, std::uint64_t seed);
/// The same; reads the frame's colours where they are needed.
cv::Mat segment(const Segmenter& segmenter, const Sequence& sequence, const SequenceFrame& frame,
                const cv::Mat& depth, std::uint64_t seed);

}  // namespace uniquadric
