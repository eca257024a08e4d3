#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/sequence/tracks.h"
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

/// An object counts as occluded where less than half of its silhouette is seen.
/// ours: by then a mask says little of the size.
inline constexpr double kOccludedFraction = 0.5;
bool is_occluded(const ObjectVisibility& visibility);

/// How long an object was followed. Frames in which it is not visible neither hit nor miss.
struct ObjectPresence {
  std::size_t visible_frames = 0;
  std::optional<double> coverage;  ///< share of the visible frames with an estimate; empty without any
  std::optional<double> coverage_of_all_frames;  ///< the same over hidden frames too; empty without frames
  /// Longest time without an estimate, a frame standing until the next one, and for a median period before a
  /// hole of the truth and at its end. Hidden frames and holes add nothing to it and do not end it. Empty
  /// when the object is never visible.
  std::optional<double> longest_gap_s;
};
ObjectPresence object_presence(const std::vector<ObjectFrame>& frames);

/// The greatest relative change |a - a_before| / a_before of a semi-axis during an occlusion, over all runs
/// of estimated frames that are occluded; a_before is that of the last estimated frame before the run. Axes
/// have the names that the estimate gave them: a name that changes with the stretch is no change of size.
/// Nothing where no occluded frame has an estimate and one before it.
std::optional<double> semi_axes_change_occluded(const std::vector<ObjectFrame>& frames);

/// Whether the truth says of any frame how much of the object is visible.
bool says_what_is_visible(const std::vector<ObjectFrame>& frames);
/// The frames of which the truth says that the object is visible. A frame keeps its relative errors if the
/// frame before it is among them.
std::vector<ObjectFrame> frames_in_view(const std::vector<ObjectFrame>& frames);

/// Figures after the start leave out this time from an object's first estimated frame.
inline constexpr double kStart_s = 3;
/// The frames from then on, the first without its relative errors; none where there is no estimate.
std::vector<ObjectFrame> frames_after_start(const std::vector<ObjectFrame>& frames);

/// The states in which an object is visible, or in which the truth does not say.
std::vector<ObjectTrack> only_in_view(std::vector<ObjectTrack> truth, const VisibilityTable& visibility);

}  // namespace uniquadric
