#pragma once

#include <map>
#include <memory>
#include <vector>

#include "core/geometry/camera.h"
#include "core/geometry/pose.h"
#include "core/sequence/sequence.h"
#include "estimator/features/patch_alignment.h"
#include "estimator/features/point_flow.h"
#include "estimator/features/rolling_shutter.h"
#include "estimator/images/plane_depth.h"
#include "estimator/images/rigid_motion.h"
#include "estimator/observation/body_hints.h"
#include "estimator/observation/perception.h"

namespace uniquadric {

/// Of the tracks that were lost and may come back. All numbers are ours.
struct GalleryOptions {
  int body_tracks = 600;                          // kept of each body, the last lost first
  static constexpr int background_tracks = 3000;  // kept of the background
  static constexpr int min_sightings = 3;         // of a track that is worth keeping
  static constexpr int max_distance = 70;    // of 256 bits: beyond, chance matches are as many as true ones
  static constexpr double max_ratio = 0.85;  // of the best match's distance to the second best's
  static constexpr int min_matches = 8;      // that must agree on one rigid motion
  static constexpr double min_share = 0.25;  // of the matches
  static constexpr double pixel_gate = 4;    // of an agreeing match
  /// A camera that lost its map is looked for where it was then, before descriptors are compared.
  bool look_where_left = true;
};

/// All numbers are ours.
struct FeatureOptions {
  int body_features = 90;                          // wanted on each body
  static constexpr int background_features = 220;  // wanted on what no mask covers
  static constexpr int fast_threshold = 8;         // grey levels, four sigma of usual image noise
  static constexpr double min_distance_px = 5;     // between features
  static constexpr int start_margin_px = 4;        // of a new feature to the next pixel of another label
  static constexpr int keep_margin_px = 2;  // of a feature that is being tracked: masks jitter by a pixel
  static constexpr int max_missed = 2;      // frames that a feature may spend off its mask
  static constexpr double max_prediction_gap_s = 0.2;  // after a longer gap nothing is known of the motion
  static constexpr double max_anchor_warp =
      1.6;  // scale or shear of a patch, either way; then a new anchor is taken
  static constexpr double min_anchor_correlation = 0.8;
  double max_pixel_sigma = 0.25;  // of an alignment [px]
  static constexpr double max_slip_px =
      0.5;  // off the landmark, of a track whose anchor does not fit any more
  static constexpr double aligned_pixel_gate =
      1;  // of tracks that were aligned: true ones are off by a tenth
  static constexpr double max_scale_change =
      0.02;                        // of depth from image to image: 0.0003 simulated, 0.01 recorded by hand
  double max_scale_refused_s = 1;  // what stays otherwise for longer is how it is
  PointFlowOptions flow;
  PatchAlignmentOptions alignment;
  PlaneDepthOptions depth;
  int descriptor_half_window_px =
      7;  // of the plane that a descriptor's view is drawn from: its normal counts
  RigidMotionOptions motion;
  RollingShutterOptions rolling_shutter;
  GalleryOptions gallery;
};

/// What one frame shows, body by body.
struct TrackedFeatures {
  std::vector<Feature> background;
  std::map<int, std::vector<Feature>> bodies;  ///< by label; those with features alone
  /// p_now = motion * p_before of each body's points in the camera frames of this and the last frame; of the
  /// bodies whose motion enough features agree on.
  std::map<int, Pose> motions;
  std::optional<Pose> background_motion;  ///< the same of the background: the camera's motion, backwards
  /// Of a rolling shutter's first frames: the background's pixels are where its rows saw them, not where they
  /// would be at the stamp, as the camera's motion is not known yet.
  bool background_at_rows = false;
  bool depth_refused = false;  ///< its scale is another one than before: none was used
  bool depth_changed = false;  ///< its scale is another one for good: all features are new
};

/// Corners on the background and on each body, tracked from frame to frame by Lucas-Kanade seeded with the
/// predicted motion and kept while they move rigidly with their body (paper: FAST, KLT, motion prior). Each
/// is aligned to what it looked like when it was found, so that it does not drift; one that was lost gets its
/// id back when it is seen again.
class FeatureTracker {
 public:
  /// `rolling_shutter_s` as in Sequence.
  FeatureTracker(const Camera& camera, const FeatureOptions& options, std::uint64_t seed,
                 double rolling_shutter_s = 0);
  ~FeatureTracker();

  /// Frames in their order. `image` CV_8UC3 or CV_8UC1; `depth` CV_32FC1 [m, 0 none] or empty; `masks`
  /// CV_16UC1 labels of the bodies, 0 background, or empty: nothing but background. `hints`: what is known of
  /// the bodies in this frame from elsewhere.
  TrackedFeatures track(const SequenceFrame& frame, const cv::Mat& image, const cv::Mat& depth,
                        const cv::Mat& masks, const BodyHints& hints = {});

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace uniquadric
