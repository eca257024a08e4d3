#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <vector>

#include "core/geometry/camera.h"
#include "core/geometry/pose.h"
#include "estimator/factors/motion_model.h"
#include "estimator/observation/perception.h"
#include "estimator/window/pose_solver.h"

namespace uniquadric {

struct ShortWindowOptions {
  int keyframes = 10;  // paper: 8-10
  static constexpr double keyframe_turn_deg =
      5;  // ours: new faces come into view by less than their corners' spacing
  static constexpr double keyframe_share =
      0.7;                       // ours: a keyframe is due when fewer of the last one's points are left
  double keyframe_gap_s = 0.33;  // ours: bounds the motion model's reach
  bool motion_model = true;      // paper: Eq. 7
  MotionNoise motion_noise;
  bool marginal_prior = true;                 // paper: e_prior
  static constexpr int max_landmarks = 4000;  // ours: bounds memory; those not seen for longest go first
  PoseSolverOptions pose;
};

/// A point of the body, fixed in its frame.
struct BodyPoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< [m]
  double sigma_m = 0;                                  ///< of a coordinate
  /// What keyframes that left the window know of it: information about `prior_position`.
  Eigen::Matrix3d prior_information = Eigen::Matrix3d::Zero();
  Eigen::Vector3d prior_position = Eigen::Vector3d::Zero();
  std::int64_t last_frame = 0;  ///< of its last sighting
  int misses = 0;               ///< sightings in a row that were outliers
};

struct BodyKeyframe {
  std::int64_t frame = 0, stamp_ns = 0;
  Pose world_from_camera, world_from_body;
  std::vector<Feature> features;  ///< inliers alone
  bool whole = true;              ///< nothing hid a part of it
};

struct BodyPose {
  Pose world_from_body;
  Matrix6d information;  ///< by its frame alone, of a right-hand perturbation (translation, rotation vector)
  bool keyframe = false;
  Pose sighted;  ///< world_from_body by this frame alone, before the window was solved with it
};

/// The short window of one body: its points and the poses of its last keyframes, by reprojection and depth
/// (Eq. 6), motion model (Eq. 7) and what left the window (e_prior). The body's frame is that of the first
/// keyframe; the camera's poses are held fixed.
class ShortWindow {
 public:
  ShortWindow(const Camera& camera, const ShortWindowOptions& options) : camera_(camera), options_(options) {}

  /// Opens the window with a first keyframe, or opens it again for a body that was lost; points that are not
  /// in view are kept.
  void start(const PerceivedFrame& frame, const BodyObservation& body, const Pose& world_from_body);

  /// The sightings of points that are known.
  std::vector<LandmarkSighting> sightings(const BodyObservation& body) const;

  /// The body's pose in this frame from the points known. Nothing when too few are seen again. `search`:
  /// without trust in the prediction.
  std::optional<PoseSolution> find(const PerceivedFrame& frame, const BodyObservation& body,
                                   const Pose& predicted_world_from_body, bool search,
                                   RandomStream& random) const;

  /// Goes on from the pose that find() found in the same frame, with a keyframe where one is due.
  BodyPose take(const PerceivedFrame& frame, const BodyObservation& body, const PoseSolution& solution);

  const std::deque<BodyKeyframe>& keyframes() const { return keyframes_; }

 private:
  bool keyframe_is_due(const PerceivedFrame& frame, bool whole, const Pose& camera_from_body, int seen) const;
  void add_keyframe(const PerceivedFrame& frame, std::vector<Feature> features, const Pose& world_from_body,
                    bool whole);
  void optimise();
  void forget_missed();
  void drop_outliers();
  void marginalise_oldest();
  void bound_memory();

  Camera camera_;
  ShortWindowOptions options_;
  std::deque<BodyKeyframe> keyframes_;
  std::map<std::int64_t, BodyPoint> landmarks_;  // by track
};

}  // namespace uniquadric
