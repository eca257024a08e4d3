#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/sequence/tracks.h"
#include "core/sequence/visibility.h"
#include "evaluation/object_frame.h"

namespace uniquadric {

/// What cuts a track into stretches at one of the truth's frames.
struct StretchFrame {
  bool has_state = false;          ///< the estimate has a state there
  bool is_hidden = false;          ///< nobody can see the object
  bool was_hidden_before = false;  ///< hidden in a frame between the one before and this one
};

/// Of each of an object's true frames what cuts its track. `statuses[k]` is the matched state's at frame k.
/// An object is hidden where the truth says that it is not visible. It is hidden, too, where the estimate
/// reports it occluded, unless the truth says that at least half of its silhouette is seen.
/// `visibility` also tells of frames that `frames` lacks.
std::vector<StretchFrame> stretch_frames(int id, const std::vector<ObjectFrame>& frames,
                                         const std::vector<std::optional<ObjectStatus>>& statuses,
                                         const VisibilityTable& visibility);

/// The first matched state of each stretch but the first, counted over the frames with a state. A stretch
/// ends before a frame without a state, and where the object becomes hidden or comes back.
std::vector<std::size_t> later_stretch_starts(const std::vector<StretchFrame>& frames);

}  // namespace uniquadric
