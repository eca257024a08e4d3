#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "core/sequence/tracks.h"
#include "estimator/factors/pose_jacobian.h"
#include "estimator/factors/pose_prior.h"

namespace uniquadric {

/// When a body counts as standing still or as moving. All numbers are ours.
struct MotionDecisionOptions {
  static constexpr double window_s = 2;  // how far back poses are compared: 2 cm/s come to ten sigmas
  static constexpr double rest_s =
      1;  // in one place for so long: a swing's turning point does not last that long
  static constexpr int rest_poses = 4;  // and so many, however far back: recordings of few frames a second
  static constexpr double rest_sigmas = 3;    // off none of the poses by more: standing still
  static constexpr double moving_sigmas = 5;  // off most of the poses by more: moving
  // of the camera's poses over such a time: several times what our odometry's are off on simulated scenes
  PoseSigmas camera_sigmas{0.001, 0.001};
  double surface_sigma_m = 0.001;  // features creep over the surface together; what is small turns by that
};

/// Static or dynamic: whether a body stands still in the world within its poses' uncertainty and the
/// camera's. A decision stands until the other one is due.
class MotionDecision {
 public:
  explicit MotionDecision(const MotionDecisionOptions& options) : options_(options) {}

  /// Where the body was seen by its frame alone (what is held still must not vouch for
  /// itself). `covariance` is of a right-hand perturbation (translation, rotation vector), `radius_m` the
  /// size of the body.
  void add(std::int64_t stamp_ns, const Pose& world_from_camera, const Pose& world_from_body,
           const Matrix6d& covariance, double radius_m);

  /// Undecided again: the body was out of sight for long.
  void forget() { *this = MotionDecision(options_); }

  ObjectMotion now() const { return decision_; }

 private:
  struct Sample {
    std::int64_t stamp_ns;
    Pose world_from_body;
    double distance_m;    // from the camera
    Matrix6d covariance;  // with the camera's and the surface's share
  };

  MotionDecisionOptions options_;
  std::deque<Sample> samples_;  // the newest last
  ObjectMotion decision_ = ObjectMotion::unknown;
  bool was_off_ = false;  // the last pose
};

}  // namespace uniquadric
