#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/sequence/estimated_objects.h"
#include "core/sequence/sequence.h"
#include "core/sequence/tracks.h"

namespace uniquadric {

/// A box or another shape as a detector gives it: at one frame, in the camera's frame.
struct BoxInCamera {
  std::int64_t frame = 0;  ///< place in the sequence, from 0
  int id = 0;              ///< of its track, positive
  Pose camera_from_object;
  ObjectShape shape;
};

/// world_from_camera at the frames of a sequence, for a result in the camera's frame: of `file` (TUM text)
/// where it exists, else the sequence's given poses, else the identity. A warning says the latter two, `name`
/// being the result's. Throws InputError where no pose of the file lies at a frame.
Trajectory camera_of_result(const std::filesystem::path& file, const Sequence& sequence,
                            const std::string& name);

/// The camera's poses and the boxes in the world, tracks in order of ids, states in order of frames. Boxes of
/// frames without a pose are left out with a warning. `camera` has stamps of frames; no two boxes of an id
/// are of one frame.
Tracks placed_in_world(std::vector<BoxInCamera> boxes, const Trajectory& camera, const Sequence& sequence,
                       const std::string& name);

}  // namespace uniquadric
