#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "core/sequence/tracks.h"
#include "core/sequence/visibility.h"

namespace uniquadric {

/// Why objects of a frame have no estimate, a short line each: no camera pose; tracks that are lost, that lie
/// between two of their states, or whose mask is in the frame (`masks`, CV_16UC1 of track ids, may be empty),
/// with what there was of a mask; and true objects that cannot be seen, by `visibility`.
std::vector<std::string> absence_notes(const Tracks& estimate, const cv::Mat& masks, std::int64_t frame,
                                       std::int64_t stamp_ns, const Tracks& truth,
                                       const VisibilityTable& visibility);

/// The state of a track at a stamp, within 0.01 s; null where it has none or says that it is lost.
const ObjectState* state_at(const ObjectTrack& track, std::int64_t stamp_ns);

/// The camera's pose at a stamp, the nearest within 0.01 s; null where there is none.
const Pose* camera_pose_at(const Trajectory& trajectory, std::int64_t stamp_ns);

/// A track's name, or # and its id.
std::string label_of(const ObjectTrack& track);

}  // namespace uniquadric
