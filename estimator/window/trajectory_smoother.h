#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/geometry/pose.h"
#include "estimator/factors/pose_jacobian.h"

namespace uniquadric {

/// What a frame's pose says of a body.
enum class PoseEvidence {
  none,      ///< nothing: it was predicted
  guess,     ///< where it probably is: found again, but not for certain
  relative,  ///< how the body went on from the frame before; where it is, has drifted
  absolute,  ///< where it is
};

/// A body's pose as it was found at one frame.
struct PoseSample {
  std::int64_t stamp_ns = 0;
  Pose world_from_object;
  Matrix6d covariance =
      Matrix6d::Identity();  ///< translation [m^2], rotation vector [rad^2]; the object's axes
  PoseEvidence evidence = PoseEvidence::absolute;
};

/// All numbers are ours.
struct TrajectorySmootherOptions {
  static constexpr double least_translation_sigma_m =
      5e-4;                                                 // of a pose: what its covariance does not know of
  static constexpr double least_rotation_sigma_rad = 2e-3;  // the same
  double guess_sigma_m = 0.02, guess_sigma_rad = 0.05;      // of a guess besides
  double outlier = 3;  // sigmas at which a pose, or a step, counts half (Cauchy)
  static constexpr int robust_rounds = 4;
  double settle_s = 0.3;  // time constant in which a new shape takes the place of the one before; 0: at once
  static constexpr double sudden =
      8;  // of the usual change of motion from state to state: a jump, before which all is forgotten
  static constexpr double history_s = 3;  // of a trajectory that goes on: how far back it is smoothed
};

/// How restless a body has been found to be: density of its jerk's noise over the variance of a pose, of
/// translation and rotation. 0: not known.
struct Restlessness {
  std::array<double, 2> jerk{};
  bool is_settled = false;  ///< taken as it is; else found again from there
};

/// The whole trajectory at once: poses as measured, and between frames a motion of constant acceleration that
/// white noise disturbs (the prior of Eq. 7 with one derivative more, over all frames; Tang et al., "A
/// white-noise-on-jerk motion prior", RA-L 2019), translation of the object's origin and rotation by
/// themselves. How restless the body is, and by how much the covariances are too small, is what makes the
/// samples most likely; samples without any noise stay as they are. Frames without evidence between others
/// are filled in; those after the last evidence stay as they are. Poses and covariances are replaced; stamps
/// are strictly increasing. `known`: from a stretch just before, and then of this one; where it is given, no
/// pose is taken for an outlier, for the newest have no later ones to speak for them.
void smooth_trajectory(std::vector<PoseSample>& samples, const TrajectorySmootherOptions& options,
                       Restlessness* known = nullptr);

}  // namespace uniquadric
