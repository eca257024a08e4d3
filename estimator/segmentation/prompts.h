#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "core/sequence/sequence.h"

namespace uniquadric {

enum class PromptKind { everything, boxes, points };

/// What the estimator is told of the objects to track.
struct Prompts {
  PromptKind kind = PromptKind::everything;
  std::filesystem::path path;  ///< file or folder of boxes, file of points

  Prompts() = default;
  /// Boxes; an empty path: everything.
  Prompts(
      const std::filesystem::path& boxes);  // NOLINT(google-explicit-constructor): a path alone means boxes
  Prompts(PromptKind prompt_kind, std::filesystem::path file) : kind(prompt_kind), path(std::move(file)) {}
  bool empty() const { return kind == PromptKind::everything; }
};

/// `everything`, `points:FILE`, `boxes:FILE-or-folder`, or a file or folder of boxes alone.
Prompts parse_prompts(const std::string& text);

/// Where an object is in one frame: an upright box in the image [px], upper left corner and size.
struct BoxPrompt {
  int id = 0;  ///< of the object, the same over the frames
  double x = 0, y = 0, width = 0, height = 0;
};

/// A pixel on an object in one frame.
struct PointPrompt {
  int id = 0;  ///< of the object; points of one id in a frame lie on one object
  double u = 0, v = 0;
};

/// Intersection over union of two boxes.
double box_iou(const BoxPrompt& a, const BoxPrompt& b);

/// Boxes of each frame (index = frame) from
/// - a folder with a file STAMP.txt a frame, lines `x y w h [score]`: ids come from `associate_boxes`; or
/// - one file with lines `stamp x y w h [id]`: ids as given, or associated when no line has one.
/// Stamps belong to the frame nearest in time within 0.01 s. Throws InputError with file and line for
/// malformed lines, empty boxes, boxes wholly outside the image, stamps of no frame and ids that stand twice
/// in a frame.
std::vector<std::vector<BoxPrompt>> read_box_prompts(const std::filesystem::path& path,
                                                     const Sequence& sequence);

/// Points of each frame (index = frame) from a file with lines `stamp u v [id]`; without ids each point of a
/// frame is an object of its own. Throws InputError as read_box_prompts does.
std::vector<std::vector<PointPrompt>> read_point_prompts(const std::filesystem::path& path,
                                                         const Sequence& sequence);

/// Whether prompts say which object each box or point is of: boxes always, by a last column or as they were
/// associated; points by a last column.
bool have_ids(const Prompts& prompts);

/// Names boxes over the frames: pairs with a track's last box by the greatest IoU, then the leftovers of a
/// frame by the nearest centre within half the image's width; a box without a partner starts a track. Ids
/// count from 1.
void associate_boxes(std::vector<std::vector<BoxPrompt>>& frames, double image_width_px);

}  // namespace uniquadric
