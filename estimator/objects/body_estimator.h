#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <vector>

#include "core/sequence/tracks.h"
#include "estimator/objects/motion_decision.h"
#include "estimator/objects/outline_watch.h"
#include "estimator/objects/shape_estimator.h"
#include "estimator/observation/perception.h"
#include "estimator/shape/body_carving.h"
#include "estimator/window/cloud_alignment.h"
#include "estimator/window/short_window.h"
#include "estimator/window/trajectory_smoother.h"

namespace uniquadric {

/// When a body counts as what. All numbers are ours.
struct LifecycleOptions {
  static constexpr int confirm_keyframes = 3;  // tentative until it has so many keyframes
  static constexpr int restart_frames =
      3;                         // in view, but none of its points found again: its short window starts anew
  double acceleration_mps2 = 2;  // how the prediction's sigma grows: hands, swings, cars
  double angular_acceleration_radps2 = 1;         // the same
  static constexpr double search_after_s = 0.25;  // a prediction older than this is not trusted
  double lost_after_s = 3;                        // of prediction alone
  bool ends_outside = true;  // or where that leaves the image: nobody says how it goes on there
  bool ends_unplaced =
      true;  // or where nothing of it is seen and the prediction's sigma exceeds its longest radius
  bool drops_models =
      true;  // begun anew where it is in view and its model fits for less long than it does not
  bool weighs_evidence = true;  // a pose by features gives way to one that surface and motion speak for more
  /// Share of the points that lie on the surface of a body that is back: any face fits any other.
  static constexpr double sure_share = 0.9;
  bool follows_points = true;  // without features it is sought where the middle of its points moved, too
};

/// What the quadric is fixed to.
enum class Parameterisation {
  object,  ///< the body, which moves: the paper's object-centric quadric (Eq. 10)
  global,  ///< the world (Eq. 8), as object SLAM has it: right for what stands still
};

struct BodyOptions {
  Parameterisation parameterisation = Parameterisation::object;
  ShortWindowOptions short_window;
  ShapeOptions shape;
  LifecycleOptions lifecycle;
  MotionDecisionOptions motion;
  CloudAlignmentOptions alignment;
  TrajectorySmootherOptions trajectory;
  CarvingOptions carving;
};

/// What is known of a body at one frame: where its short window's frame is, and the shape in it.
struct BodyState {
  std::int64_t frame = 0, stamp_ns = 0;
  Pose world_from_body;
  Matrix6d covariance = Matrix6d::Zero();  ///< of world_from_body
  Shape shape;
  ObjectStatus status = ObjectStatus::tentative;
  PoseEvidence evidence = PoseEvidence::absolute;  ///< what the pose goes by
  int beginning = 0;  ///< how often the body was begun anew: poses before have another frame
  ObjectMotion motion = ObjectMotion::unknown;
};

/// Whether a pose is known better than the body is large, in every direction: one that is not, as by the last
/// sliver of a body before it is hidden, says nothing of its shape. `covariance`: of a right-hand
/// perturbation of the body's pose (translation [m^2], rotation vector).
bool is_placed(const Matrix6d& covariance, const Shape& shape);

/// One body through its life: initialised as a sphere and then by Alg. 1 (the paper's SQI), tracked by the
/// short window, modelled by the long one, predicted while it is hidden, found again by its points.
class BodyEstimator {
 public:
  BodyEstimator(int id, const Camera& camera, const BodyOptions& options, std::uint64_t seed);

  /// The next frame; `body` null where perception has nothing of it. Nothing before the body has been
  /// initialised, while the camera's pose is unknown, and after it was lost: where its prediction is given up
  /// it says so in a last state (ObjectStatus::lost), until it is found again.
  /// `times` receives what each solution of the long window took; null: nothing does.
  std::optional<BodyState> step(const PerceivedFrame& frame, const BodyObservation* body,
                                std::vector<StageTime>* times = nullptr);

  /// world_from_body at a frame that comes, of a body that has been found before: perception's own motion of
  /// `body` since the last frame where there is one, else constant velocity, or rest.
  Pose predict(const PerceivedFrame& frame, const BodyObservation* body) const;

  /// Looks once more at a frame whose pose was a guess: about `expected` world_from_body, by all of the
  /// surface that is known by now. Where that fits, `state` has its pose, and is still a guess. States of a
  /// life before the last one stay as they are.
  void look_again(const PerceivedFrame& frame, const BodyObservation& body, const Pose& expected,
                  BodyState& state) const;

  /// Whether a state is of the life that goes on, in whose frame the surface is.
  bool is_present(const BodyState& state) const { return state.beginning == beginnings_; }

  /// What has been seen of its surface, in the body's frame.
  SurfaceModel surface() const { return shape_.surface(); }

 private:
  struct Tracked {
    std::int64_t frame, stamp_ns;
    Pose world_from_camera, world_from_body;
    Matrix6d covariance;
    std::optional<Eigen::Vector3d> middle{};  // of its points, in the world, where nothing hid a part of it
  };

  void begin_anew();
  bool is_global() const { return options_.parameterisation == Parameterisation::global; }
  BodyState guessed(const PerceivedFrame& frame, const BodyPose& pose);
  BodyState found(const PerceivedFrame& frame, const BodyObservation& body, bool own_outline,
                  const BodyPose& pose);
  std::optional<BodyState> unseen(const PerceivedFrame& frame, const BodyObservation* body);
  bool start(const PerceivedFrame& frame, const BodyObservation& body);
  bool has_own_outline(const PerceivedFrame& frame, const BodyObservation& body) const;
  bool was_a_glimpse(double hidden_s) const;
  bool has_wrong_model(const PerceivedFrame& frame, const BodyObservation& body);
  void remember(const PerceivedFrame& frame, const Pose& world_from_body, const Matrix6d& covariance);
  std::optional<BodyPose> track(const PerceivedFrame& frame, const BodyObservation& body);
  SurfaceModel surface_of_before() const;
  bool come_back(const PerceivedFrame& frame, const BodyObservation& body, Pose& world_from_body);
  void settle(const PerceivedFrame& frame, const BodyObservation& body, BodyPose& pose);
  BodyPose stand_still(const PerceivedFrame& frame) const;
  std::optional<BodyPose> align(const PerceivedFrame& frame, const BodyObservation& body);
  std::optional<CloudAlignment> aligned(const PerceivedFrame& frame, const BodyObservation& body) const;
  std::optional<CloudAlignment> aligned_to(const PerceivedFrame& frame, const BodyObservation& body,
                                           const SurfaceModel& surface) const;
  std::optional<CloudAlignment> found_by_shape(const PerceivedFrame& frame, const BodyObservation& body,
                                               SurfaceModel surface, Pose predicted) const;
  std::optional<Eigen::Vector3d> center_by_points(const PerceivedFrame& frame,
                                                  const BodyObservation& body) const;
  Eigen::Vector3d body_center() const { return shape_.shape().body_from_object.translation; }
  void place_center(Pose& world_from_body, const Eigen::Vector3d& at) const;
  std::vector<Pose> expected_at(const PerceivedFrame& frame, const BodyObservation& body) const;
  std::optional<CloudAlignment> aligned_from(const PerceivedFrame& frame, const BodyObservation& body,
                                             const SurfaceModel& surface, const Pose& camera_from_body,
                                             const PoseSigmas& sigmas) const;
  std::vector<Disagreement> disagreements_of(const PerceivedFrame& frame, const BodyObservation& body,
                                             const SurfaceModel& surface,
                                             const std::vector<Pose>& poses) const;
  bool gives_way(const PerceivedFrame& frame, const BodyObservation& body,
                 const Pose& camera_from_body) const;
  std::optional<CloudAlignment> best_of(const PerceivedFrame& frame, const BodyObservation& body,
                                        const SurfaceModel& surface,
                                        const std::vector<CloudAlignment>& ends) const;
  bool is_out_of_reach(const PerceivedFrame& frame, const Pose& world_from_body) const;
  bool is_stale(const PerceivedFrame& frame) const;
  bool has_left(const PerceivedFrame& frame, const Pose& world_from_body, double sigma_m) const;
  PoseSigmas prediction_sigmas_at(const PerceivedFrame& frame, std::int64_t since_ns) const;
  BodyState state_at(const PerceivedFrame& frame, const Pose& world_from_body,
                     const Matrix6d& covariance) const;

  int id_;
  Camera camera_;
  BodyOptions options_;
  std::uint64_t seed_;
  ShortWindow short_window_;
  ShapeEstimator shape_;
  MotionDecision motion_;
  OutlineWatch outlines_;
  std::deque<Tracked> recent_;                 // frames with a tracked pose, the newest last
  std::int64_t sure_ns_ = 0, sure_frame_ = 0;  // of the last pose that was no guess
  std::optional<ShapeEstimator> strayed_;      // as it was before a new face alone was to go by
  int keyframes_ = 0, frames_unfound_ = 0;
  int frames_placed_ = 0;  // in all, by a pose that is better known than the body is large
  int frames_misfit_ = 0;  // since the last pose, in view
  int beginnings_ = 0;
  bool said_lost_ = false;
};

}  // namespace uniquadric
