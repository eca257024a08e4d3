#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <functional>

#include "core/geometry/pose.h"
#include "estimator/ego/lidar_map.h"

namespace uniquadric {

inline constexpr int kLidarDof = 18;     ///< of the state
inline constexpr int kSightingDof = 12;  ///< the first ones, which a point depends on
using Vector18d = Eigen::Matrix<double, kLidarDof, 1>;
using Matrix18d = Eigen::Matrix<double, kLidarDof, kLidarDof>;
using Row12d = Eigen::Matrix<double, 1, kSightingDof>;
using SightingSquare = Eigen::Matrix<double, kSightingDof, kSightingDof>;

/// Where each part of the error begins: turn of the body (right), place, velocity, biases, gravity.
enum LidarError { kTurn = 0, kPlace = 3, kVelocity = 6, kGyroscope = 9, kAccelerometer = 12, kGravity = 15 };

/// The filter's state (FAST-LIO2, arXiv 2107.06829, Eq. 4, the extrinsics being known). Without an IMU the
/// same state moves by readings that are zero: the gyroscope's bias is then minus the body's turn rate, and
/// gravity is none, which is the model of constant velocity.
struct LidarState {
  std::int64_t stamp_ns = 0;
  Pose world_from_body;
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();  ///< in the world
  Eigen::Vector3d gyroscope_bias_radps = Eigen::Vector3d::Zero();
  Eigen::Vector3d accelerometer_bias_mps2 = Eigen::Vector3d::Zero();
  Eigen::Vector3d gravity_mps2 = Eigen::Vector3d::Zero();  ///< in the world, downwards
};
LidarState moved(const LidarState& state, const Vector18d& error);
/// The error that moves b to a.
Vector18d difference(const LidarState& a, const LidarState& b);

/// What the body's IMU reads; all zero without one.
struct InertialReading {
  Eigen::Vector3d angular_velocity_radps = Eigen::Vector3d::Zero();
  Eigen::Vector3d specific_force_mps2 = Eigen::Vector3d::Zero();
};
/// Densities of the noise in a propagation, as in ImuCalibration.
struct InertialNoise {
  double gyroscope = 0, gyroscope_walk = 0, accelerometer = 0, accelerometer_walk = 0;
};

/// The state at a later (or earlier) time, the reading being constant.
LidarState propagated(const LidarState& state, const InertialReading& reading, std::int64_t to_ns);
/// Of the error at to_ns by that at state.stamp_ns.
Matrix18d propagation_jacobian(const LidarState& state, const InertialReading& reading, std::int64_t to_ns);
Matrix18d propagation_noise(const InertialNoise& noise, double dt_s);

/// A point of a sweep, placed by the motion in it: measured age_s before the state, when the body was turned
/// by end_from_then, and bend_m (world) off a straight path.
struct SweepPoint {
  Eigen::Vector3d body = Eigen::Vector3d::Zero();  ///< in the body's frame at the point's own time [m]
  Eigen::Matrix3d end_from_then = Eigen::Matrix3d::Identity();
  Eigen::Vector3d bend_m = Eigen::Vector3d::Zero();
  double age_s = 0;
};

/// The same by the state at the sweep's end: velocity and turn rate are part of it, the more so the older the
/// point.
struct EndPoint {
  Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();          ///< since the point, beyond end_from_then
  Eigen::Quaterniond turned = Eigen::Quaterniond::Identity();  ///< by turn_rad
  Eigen::Vector3d body = Eigen::Vector3d::Zero();              ///< in the axes of the body at the end
};
/// `path_bias` is the gyroscope's bias that end_from_then was made with.
EndPoint end_point(const LidarState& end, const Eigen::Vector3d& path_bias, const SweepPoint& point);
Eigen::Vector3d world_point(const LidarState& end, const SweepPoint& point, const EndPoint& at_end);
/// Distance of the point from the plane.
double plane_distance(const LidarState& end, const SweepPoint& point, const EndPoint& at_end,
                      const MapPlane& plane);
/// The distance's derivative by the error of the state, which is linear in the plane's normal.
Row12d distance_jacobian(const LidarState& end, const SweepPoint& point, const EndPoint& at_end,
                         const Eigen::Vector3d& normal);

/// Sum of weight J^T J and weight J^T r over points.
struct LidarNormal {
  SightingSquare square = SightingSquare::Zero();
  Eigen::Matrix<double, kSightingDof, 1> side = Eigen::Matrix<double, kSightingDof, 1>::Zero();
  int points = 0;
};

struct LidarBelief {
  LidarState state;
  Matrix18d covariance = Matrix18d::Zero();
};
/// The belief propagated under one reading.
LidarBelief propagated(const LidarBelief& belief, const InertialReading& reading, const InertialNoise& noise,
                       std::int64_t to_ns);
/// The belief, gravity being put back on the sphere of its strength, as in FAST-LIO2: its direction alone is
/// unknown. Without it a constant acceleration that is not there is taken for a tilt. (A measurement of the
/// length in its place, linearised where gravity was taken to point at first, holds it there.)
LidarBelief with_gravity(const LidarBelief& belief, double magnitude_mps2);
/// The iterated update (FAST-LIO2, Eq. 12-18; the gain is written with neither the covariance's inverse nor
/// one of the size of the points). `normal_at` is asked for the points' sums at each iterate, and which it
/// is; iterations end when a step turns and shifts by less than the limits.
LidarBelief updated(const LidarBelief& prior,
                    const std::function<LidarNormal(const LidarState&, int iteration)>& normal_at,
                    int max_iterations);

}  // namespace uniquadric
