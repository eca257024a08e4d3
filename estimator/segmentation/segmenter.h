#pragma once

#include <any>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <set>
#include <string>
#include <vector>

#include "core/sequence/sequence.h"
#include "estimator/base/option_io.h"
#include "estimator/segmentation/prompts.h"

namespace uniquadric {

/// A frame as a segmenter sees it.
struct SegmenterInput {
  SequenceFrame frame;
  cv::Mat rgb;      ///< CV_8UC3; may be empty for the sequence's own masks
  cv::Mat depth;    ///< CV_32FC1 [m], 0 none
  cv::Mat tracked;  ///< CV_16UC1: masks carried from earlier frames, may be empty; their bodies are prompts
                    ///< where the user gives none for them in this frame
};

/// What a segmenter is asked for in a frame: everything, or what is in boxes or at points. The user's
/// prompts, and one for each tracked body that they leave out.
struct FramePrompts {
  PromptKind kind = PromptKind::everything;
  std::vector<BoxPrompt> boxes;
  std::vector<PointPrompt> points;
};

/// Finds the masks of a frame. docs/add_segmenter.md adds one.
class Segmenter {
 public:
  virtual ~Segmenter() = default;
  /// Object ids of the frame's pixels (CV_16UC1, 0 background): those of the prompts, else any; an empty
  /// image where there is nothing to go by.
  virtual cv::Mat segment(const Sequence& sequence, const SegmenterInput& input, const FramePrompts& prompts,
                          std::uint64_t seed) const = 0;
};

struct SegmentationOptions;

/// A segmenter that a variant can choose: `segmentation: {source: NAME}`.
struct SegmenterKind {
  std::string name;
  std::set<PromptKind> prompts;  ///< that it takes
  std::any options;              ///< their defaults
  std::function<void(OptionReader&, std::any&)> read;
  std::function<void(OptionWriter&, std::any&)> write;
  std::function<std::shared_ptr<const Segmenter>(const SegmentationOptions&, PromptKind)> make;
};

/// Which segmenter, and the options of each that is not as it is by default.
struct SegmentationOptions {
  std::string source = "automatic";  ///< a kind's name, or `automatic`: the sequence's own masks where it has
                                     ///< some, else grabcut_depth for boxes, else depth_motion
  std::map<std::string, std::any> options;  ///< by the kind's name

  /// Those of a kind, of its type.
  template <typename Options>
  Options of(const std::string& kind) const {
    const auto found = options.find(kind);
    return found == options.end() ? Options() : std::any_cast<Options>(found->second);
  }
};

/// Of a class with `Options`, a constructor that takes them, and `visit(io, Options&)` that names their keys
/// (option_io.h).
template <typename T>
SegmenterKind segmenter_kind(const std::string& name, const std::set<PromptKind>& prompts) {
  using Options = typename T::Options;
  return {name,
          prompts,
          Options(),
          [](OptionReader& io, std::any& options) { visit(io, std::any_cast<Options&>(options)); },
          [](OptionWriter& io, std::any& options) { visit(io, std::any_cast<Options&>(options)); },
          [name](const SegmentationOptions& options, PromptKind) -> std::shared_ptr<const Segmenter> {
            return std::make_shared<T>(options.of<Options>(name));
          }};
}

inline constexpr const char* kSequenceMasks =
    "sequence";                                  ///< masks/ of the sequence: the simulated segmenter
inline constexpr const char* kNoMasks = "none";  ///< no objects: all is background

/// All kinds.
const std::vector<SegmenterKind>& segmenter_kinds();
/// Asserts that there is one of that name.
const SegmenterKind& segmenter_kind_of(const std::string& name);

// Names of the options' keys, for reading and writing (option_io.h).
void visit(OptionReader& io, SegmentationOptions& options);
void visit(OptionWriter& io, SegmentationOptions& options);

}  // namespace uniquadric
