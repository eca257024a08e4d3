#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "estimator/features/corners.h"
#include "estimator/features/features.h"
#include "estimator/features/rolling_shutter.h"
#include "estimator/features/tracked_body.h"

namespace uniquadric {

/// One frame as the parts of feature tracking see it.
struct FrameView {
  const Camera& lens;    ///< as it is
  const Camera& camera;  ///< without distortion
  const RollingShutter& shutter;
  const FeatureOptions& options;
  const BodyHints& hints;
  cv::Mat gray, depth;  ///< CV_8UC1; CV_32FC1 [m] or empty
  Regions regions;
  std::int64_t frame = 0, step_ns = 0;
  std::uint64_t seed = 0;
  SurfaceNoise noise{};

  /// Puts a track of a body at a pixel and measures its depth where it would be seen at the stamp, of which
  /// depth and labels are; false where the lens has no ray.
  bool place(PointTrack& track, const Eigen::Vector2d& pixel, const TrackedBody& body) const;
  /// The same with a quick look at the depth, for a place that is not the last.
  bool place_roughly(PointTrack& track, const Eigen::Vector2d& pixel, const TrackedBody& body) const;
  /// Whether the envelope has no objection.
  bool belongs(int label, const PointTrack& track) const;
  int most_tracks(int label) const;  ///< of a body's gallery

 private:
  std::optional<PlaneDepth> quick_depth(const Eigen::Vector2d& pixel) const;
  std::optional<Eigen::Vector2d> at_stamp(const PointTrack& track, const Eigen::Vector2d& pixel,
                                          const TrackedBody& body) const;
};

/// Where a body's map is expected in this frame, by a hint or as it moved last; its last pose when the motion
/// is not known.
std::optional<Pose> expected_pose(const FrameView& view, const TrackedBody& body);

/// Moves a body by its tracks, which have been followed into this frame: RANSAC, alignment of each track to
/// its anchor, and the pose of what agrees. Tracks that move otherwise are dropped. Without a consensus the
/// pose is given up, and the tracks too when there were enough of them to agree.
void move_body(const FrameView& view, TrackedBody& body);

/// The pose that most of the body's tracks agree on, from a prior; drops the others. False, and nothing
/// changed, without a consensus. `pass` tells the random numbers of two calls in one frame apart.
bool fit_pose(const FrameView& view, TrackedBody& body, const Pose& prior, int pass);

/// A hand may turn otherwise than in the last frame, so that only rows near the middle agree at first: they
/// tell the twist by which the next ones do. Moves the body's tracks by it, and returns where the body is
/// then; `expected`, and nothing moved, without a rolling shutter or a twist in the last frame.
Pose follow_twist(const FrameView& view, TrackedBody& body, const Pose& expected);

/// Finds the body's twist and, with it, its pose once more, from how it moved since `before` and from the
/// rows of this frame, and moves its tracks by it. Landmarks of a presumed twist are given up. With a rolling
/// shutter alone.
void find_twist(const FrameView& view, TrackedBody& body, const Pose& before);

/// Notes how the body has moved from its last pose, in the same map, to the present one.
void set_motion(const FrameView& view, TrackedBody& body, const Pose& before);

/// Looks for lost tracks of the present map where they should be seen, by their anchors; at most `wanted`.
void return_expected_tracks(const FrameView& view, TrackedBody& body, Spacing& spacing, double distance_px,
                            int wanted);

/// Looks for the lost tracks of a body whose pose is not known as if it had been at rest since it was lost;
/// at most `wanted`. Where enough agree, they are the body's again and its pose is known.
void return_where_left(const FrameView& view, TrackedBody& body, double distance_px, int wanted);

/// Compares new corners (tracks with a place, depth and descriptors that are not yet the body's) with the
/// lost tracks of all maps, when the body's pose is not known, or else of the other ones. Where enough of
/// them agree the pose is known in that map, and the present map becomes a part of it. Recognised corners
/// become the body's, with their old ids and landmarks, and leave `corners`.
void recognise_body(const FrameView& view, TrackedBody& body, std::vector<PointTrack>& corners);

}  // namespace uniquadric
