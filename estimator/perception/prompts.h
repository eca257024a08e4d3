#pragma once

#include <filesystem>
#include <vector>

#include "core/sequence/sequence.h"

namespace uniquadric {

/// Where an object is in one frame: an upright box in the image [px], upper left corner and size.
struct BoxPrompt {
  int id = 0;  ///< of the object, the same over the frames
  double x = 0, y = 0, width = 0, height = 0;
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

/// Names boxes over the frames: pairs with a track's last box by the greatest IoU, then the leftovers of a
/// frame by the nearest centre within half the image's width; a box without a partner starts a track. Ids
/// count from 1.
void associate_boxes(std::vector<std::vector<BoxPrompt>>& frames, double image_width_px);

}  // namespace uniquadric
