#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/sequence/visibility.h"
#include "evaluation/object_frame.h"

namespace uniquadric {

/// An object counts as visible in a frame that shows at least this share of its silhouette and so many
/// pixels.
/// ours: a tenth is less than any segmenter finds, 50 px are the simulated segmenter's least mask.
inline constexpr double kVisibleFraction = 0.1;
inline constexpr std::int64_t kVisible_px = 50;

/// Whether there is enough of the object to be seen.
bool is_visible(const ObjectVisibility& visibility);

/// How long an object was followed. Frames in which it is not visible neither hit nor miss.
struct ObjectPresence {
  std::size_t visible_frames = 0;
  std::optional<double> coverage;  ///< share of the visible frames with an estimate; empty without any
  std::optional<double> coverage_of_all_frames;  ///< the same over hidden frames too; empty without frames
  /// Longest time without an estimate, a frame standing until the next one; hidden frames add nothing to it.
  /// Empty when the object is never visible.
  std::optional<double> longest_gap_s;
};
ObjectPresence object_presence(const std::vector<ObjectFrame>& frames);

}  // namespace uniquadric
