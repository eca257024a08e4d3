#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "core/geometry/camera.h"
#include "core/sequence/sequence.h"
#include "core/sequence/trajectory.h"
#include "estimator/ego/bundle_adjustment.h"
#include "estimator/ego/ego_map.h"
#include "estimator/ego/loop_closure.h"
#include "estimator/ego/world_frame.h"
#include "estimator/features/features.h"
#include "estimator/images/rigid_motion.h"

namespace uniquadric {

/// All numbers are ours.
struct EgoOptions {
  EgoOptions() {
    pose.pixel_gate = 2;
    pose.min_inliers = 12;
    pose.min_share = 0.3;
    pose.pixel_sigma = 0.15;
    loop.motion = pose;
    loop.motion.min_share = 0.5;
  }
  RigidMotionOptions pose;  // of a frame, by points of the map
  static constexpr double keyframe_min_share =
      0.75;  // of the last keyframe's points still seen; below, a new one
  static constexpr double keyframe_shift =
      0.05;  // of the camera since the last keyframe, share of the median depth
  static constexpr double keyframe_turn_rad = 0.1;
  static constexpr int keyframe_max_gap = 15;  // frames
  static constexpr int window_keyframes = 8;   // that move in the local bundle adjustment
  static constexpr int final_iterations = 20;  // over all keyframes, when the trajectory is asked for
  /// Frames: a map that is lost for young_lost_frames before it has placed young_frames was begun on a bad
  /// one.
  int young_frames = 10, young_lost_frames = 3;
  /// After this time [s], while at least this many background features with depth are followed from frame to
  /// frame, the world is not the map's any more (the depth has another scale, or all has been moved): a new
  /// one begins.
  static constexpr double restart_after_s = 1;
  static constexpr int restart_features = 40;
  /// A frame that does not fit the map is placed by the background's motion since the frame before, where at
  /// least this many features with depth are followed. 0: never.
  int bridge_features = 12;
  BundleOptions bundle;
  LoopOptions loop;
  UprightOptions upright;
};

/// Visual odometry with depth: each frame's pose by the points of the map that its features are (RANSAC with
/// the motion prior, robust least squares), keyframes, local bundle adjustment, and a pose graph where old
/// points come back. A frame that does not fit the map is placed by the background's motion. A map that
/// nothing fits any more is given up: at the start as if it had never been, later a new one goes on from the
/// last known pose. The world has its origin at the first camera and z up, by the floor where the first
/// frames show one, else by the camera's own up.
class RgbdOdometry {
 public:
  /// `fixed_lag_s`: of lagged_trajectory(). `rolling_shutter_s`: as in Sequence.
  RgbdOdometry(const Camera& camera, const EgoOptions& options, std::uint64_t seed, double fixed_lag_s = 1,
               double rolling_shutter_s = 0);
  ~RgbdOdometry();

  /// Frames in their order. `depth` and `masks` as in FeatureTracker::track; only to find the floor.
  void track(const SequenceFrame& frame, const TrackedFeatures& features, const cv::Mat& depth,
             const cv::Mat& masks);

  /// world_from_camera at the last frame, as known then; nothing when the camera is lost.
  std::optional<Pose> pose() const;

  /// world_from_camera of all frames but those where the camera was lost, with all that is known now.
  Trajectory trajectory() const;
  /// The same as known at each frame. Where a young map was given up, its frames are missing.
  Trajectory causal_trajectory() const;
  /// The same as known `fixed_lag_s` after each frame, or now. After the last frame.
  Trajectory lagged_trajectory();

  /// Of the world as it is known now.
  const EgoMap& map() const;

  /// Features by which frames of the present map will be placed once more: as many as the frames of the local
  /// bundle adjustment have.
  std::int64_t features_kept() const;

  /// How often a new map went on from the last known pose: what moved meanwhile is missing there.
  int restarts() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace uniquadric
