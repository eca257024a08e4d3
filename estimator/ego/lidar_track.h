#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/geometry/camera.h"
#include "core/geometry/pose.h"
#include "core/sequence/imu.h"
#include "core/sequence/lidar.h"
#include "estimator/ego/lidar_filter.h"
#include "estimator/ego/lidar_map.h"
#include "estimator/ego/lidar_registration.h"
#include "estimator/ego/lidar_sweep.h"

namespace uniquadric {

/// All numbers are ours, chosen on subway_car.
struct LidarOdometryOptions {
  bool use_imu = true;  // where the sequence has one
  SweepOptions sweep;
  LidarMapOptions map;
  // Without an IMU: how restless the sensor is.
  double acceleration_mps2_rthz = 1.0;
  double angular_acceleration_radps2_rthz = 1.0;
  double bend_mps = 0.3, bend_radps = 0.1;  // of the map, see with_bent_map
  LidarSightOptions sight;
  int iterations = 4;
  double lost_sigma_m = 1.0;  // of the place: beyond it the sensor is lost
  double found_share = 0.5;   // of the points that are usually on planes: fewer, and a sensor whose place is
                              // uncertain by half of lost_sigma_m is not believed to be found
  double first_velocity_mps = 3;  // standard deviation, of the best of the first velocities that are tried
  int first_sweeps =
      10;  // gone through first_passes times at least, for the first motion undoes the first cloud
  int first_passes = 3;
  double first_sweep_s = 0.1;     // least length of those sweeps: shorter ones are joined
  double first_change_mps = 0.3;  // by the last pass, of the first velocity; more: it is not known, and the
                                  // beginning is put off
};

/// What the odometry knows of its sensors.
struct LidarRigView {
  Pose camera_from_lidar;
  std::optional<ImuCalibration> imu;  ///< nothing: constant velocity
  std::optional<Camera> camera;       ///< of the masks; nothing: no masks
  LidarDataSheet noise{};
};

/// What stays the same while a sensor is followed.
struct LidarSetting {
  LidarRigView rig;
  std::vector<ImuSample> imu;  ///< none: constant velocity
  LidarOdometryOptions options;
  Pose body_from_lidar, body_from_camera;  ///< the body is the IMU, without one the LiDAR
};
/// Readings that the options or the rig do not know of are left out, and forces where there is no gravity.
LidarSetting lidar_setting(const LidarRigView& rig, std::vector<ImuSample> imu,
                           const LidarOdometryOptions& options);
/// Of whose IMU the turn rates alone count: its velocity is as restless as without one.
LidarSetting without_force(LidarSetting setting);
bool feels_force(const LidarSetting& setting);

/// The points of a stretch of time in the order of their stamps, without those on bodies.
struct LidarSweep {
  std::int64_t end_ns = 0;
  std::vector<TimedPoint> points;
  int on_bodies = 0;
};

/// What is known at a sweep's end.
struct LidarFix {
  LidarState state;
  Eigen::Vector3d turn_rate_radps = Eigen::Vector3d::Zero();  ///< in the body's axes
  double sigma_m = 0;                                         ///< of the place
};

/// A sensor followed from a start: sweep by sweep the filter, and the map that it makes.
class LidarTrack {
 public:
  /// The setting has to outlive this. `row_gap_rad`: between the rows of a spinning sensor; 0: none.
  explicit LidarTrack(const LidarSetting& setting, double row_gap_rad = 0);

  /// Begins anew. A start that an earlier pass found (no guess) is known as well as its velocity and turn
  /// rate were after that pass.
  void begin_at(const LidarState& start, bool is_guess);
  /// The thickness of the planes that count from here on (LidarSightOptions::max_thickness).
  void allow_thickness(double max_thickness) { sight_.max_thickness = max_thickness; }
  /// Without points the motion goes on.
  void go_on(const LidarSweep& sweep);

  const LidarBelief& belief() const { return belief_; }
  /// The start's, and one a sweep.
  const std::vector<LidarFix>& fixes() const { return fixes_; }
  const std::vector<SweepReport>& reports() const { return reports_; }
  const LidarMap& map() const { return map_; }

 private:
  void note_fix();
  void note(const SweepReport& report);
  double place_sigma_m() const;

  const LidarSetting* setting_;
  double row_gap_rad_;
  LidarSightOptions sight_;
  LidarBelief belief_;
  LidarMap map_;
  double usual_share_ = 0;  // of the points on planes; 0: unknown
  std::vector<LidarFix> fixes_;
  std::vector<SweepReport> reports_;
};

}  // namespace uniquadric
