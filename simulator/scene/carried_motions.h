#pragma once

#include <cstdint>
#include <vector>

#include "simulator/scene/motion.h"

namespace uniquadric {

/// What a hand adds to where it wants to be. Each axis is a sum of sinusoids from 0.3 to 12 Hz: a slow sway
/// whose amplitudes fall with the frequency, and the physiological tremor of 8 to 12 Hz (Elble and Koller,
/// "Tremor", 1990), which has a tenth of the variance. Phases are random, of the stream (seed, "tremor",
/// axis). To be composed: the other motion first.
struct TremorOptions {
  double position_m = 0.001;     ///< root mean square of each axis
  double rotation_rad = 0.0035;  ///< root mean square of the turn about each axis
  std::uint64_t seed = 0;
};
Motion tremor_motion(const TremorOptions& options);

/// A stretch of a drive with constant acceleration and steering angle.
struct DriveLeg {
  double duration_s = 1, acceleration_mps2 = 0, steer_rad = 0;
};

/// A car by the kinematic bicycle model, exactly: the middle of its rear axle moves along circles of
/// curvature tan(steer) / wheelbase by the arc length s(t) = v t + a t^2 / 2. At the start of a leg the
/// curvature goes from the last leg's to its own, evenly along the way of `steering_s`: a clothoid. Where it
/// jumped, all that is not on the axle would get a blow that no accelerometer can show. The car never goes
/// backwards: braked to rest it stays. Before the first leg and after the last it keeps speed and curvature.
/// The body's origin lies `ahead_m` of the axle and `height_m` above the ground; x forward, z up, or with
/// `optical` a camera that looks forward.
struct DriveOptions {
  Eigen::Vector2d start_m = Eigen::Vector2d::Zero();  ///< of the rear axle's middle
  double heading_rad = 0, speed_mps = 10, begins_s = 0;
  double steering_s = 0.3, wheelbase_m = 2.7, ahead_m = 1.35, height_m = 0;
  std::vector<DriveLeg> legs;
  bool optical = false;
};
Motion drive_motion(const DriveOptions& options);

}  // namespace uniquadric
