#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/geometry/pose.h"
#include "core/sequence/sequence.h"
#include "estimator/features/frame_pair.h"

namespace uniquadric {

/// Two frames with what both of them show, and the camera's motion between them.
struct FramePair {
  std::size_t first = 0, second = 0;  ///< of sequence.frames
  std::vector<PointPair> points;
  std::optional<Pose> b_from_a;  ///< by depth and pixels; nothing where too few points agree
  double share = 1;              ///< of the points with depth that agree
  double least_way_m = 0.015;    ///< of the camera, that is known well enough to tell a scale
};

/// As many pairs of frames as asked for, evenly spread over the sequence. The frames of a pair lie as far
/// apart as most corners can be followed.
std::vector<FramePair> frame_pairs(const Sequence& sequence, int pairs);

/// The pixel in b that a point of a has after a motion; nothing behind the camera or without depth.
std::optional<Eigen::Vector2d> moved_pixel(const PointPair& point, const Camera& camera,
                                           const Pose& b_from_a);

/// Fits `b_from_a` and `share` to the points with depth in both frames.
void fit_pair(const Camera& camera, FramePair& pair);

}  // namespace uniquadric
