#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>

#include "core/geometry/pose.h"

namespace uniquadric {

struct PerceivedFrame;

/// Whether a point in the camera frame can belong to a body.
using BodyEnvelope = std::function<bool(const Eigen::Vector3d& p_camera)>;

/// What is told to the tracking of features of one body in the frame that comes.
struct BodyHint {
  /// Expected p_now = motion * p_before, in the camera frames of this and the last frame; nothing: as it
  /// moved last.
  std::optional<Pose> motion;
  BodyEnvelope envelope;  ///< of the body where it is expected; empty: not known
};

using BodyHints = std::map<int, BodyHint>;  ///< by the body's id

/// An estimator of the bodies that perception runs joined with, frame by frame.
class BodyFeedback {
 public:
  virtual ~BodyFeedback() = default;
  /// For the frame that comes.
  virtual BodyHints hints(std::int64_t frame, std::int64_t stamp_ns) = 0;
  /// The frame as it was perceived, with the camera's pose and the outlines as known by then.
  virtual void take(const PerceivedFrame& frame) = 0;
};

}  // namespace uniquadric
