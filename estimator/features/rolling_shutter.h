#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/geometry/camera.h"
#include "core/geometry/pose.h"
#include "estimator/images/rigid_motion.h"

namespace uniquadric {

/// All numbers are ours.
struct RollingShutterOptions {
  bool enabled = true;  // false: all rows are taken for exposed at the stamp
  /// Standard deviations of a body's twist about that from the last frame to this one: a hand's tremor of
  /// 10 Hz, 1 mm and 0.15 degrees changes it so much in half a frame.
  double velocity_sigma_mps = 0.05, turn_sigma_radps = 0.05;
};

/// Moves pixels between the time at which their row is exposed and the frame's stamp. A body's twist xi [1/s]
/// is that of its points in the camera frame: p(stamp + t) = exp(t xi) p(stamp).
class RollingShutter {
 public:
  /// `lens` as it is, kept; `readout_s` from the first row to the last, the middle one at the stamp.
  RollingShutter(const Camera& lens, double readout_s) : lens_(lens), readout_s_(readout_s) {}

  bool is_on() const { return readout_s_ > 0; }
  /// How long after the stamp a row is exposed [s].
  double delay_s(double row) const;
  /// Where a point, in the camera frame at the stamp, is seen in the image; nothing where it is not.
  std::optional<Eigen::Vector2d> seen_at(const Eigen::Vector3d& point, const Vector6d& twist) const;
  /// Where what is seen at a pixel would be seen at the stamp, at depth `depth_m` then; nothing where the
  /// lens has no ray. Both pixels are raw.
  std::optional<Eigen::Vector2d> at_stamp(const Eigen::Vector2d& pixel, double depth_m,
                                          const Vector6d& twist) const;

 private:
  Camera lens_;
  double readout_s_ = 0;
};

/// A body's pose at the stamp and its twist.
struct MovingPose {
  Pose camera_from_body;
  Vector6d twist = Vector6d::Zero();
};

/// Both by sightings whose pixels were moved to the stamp by `start.twist`, from rows exposed `delays_s`
/// after it: robust least squares, where a change of the twist moves each pixel by its delay. `expected` is
/// what the twist is without them. Nothing where the equations have no solution.
std::optional<MovingPose> fit_moving_pose(const std::vector<PointSighting>& sightings,
                                          const std::vector<double>& delays_s, const Camera& camera,
                                          const MovingPose& start, const Vector6d& expected,
                                          double pixel_sigma, const RollingShutterOptions& options);

}  // namespace uniquadric
