#include "estimator/ego/lidar_filter.h"

#include <Eigen/LU>
#include <cmath>

namespace uniquadric {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kSmallAngle = 1e-4;                         // rad: below it the series is exact to 1e-16
constexpr double kStepTurn_rad = 1e-5, kStepShift_m = 1e-4;  // far under what a sweep tells

Matrix3d skew(const Vector3d& v) {
  Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

// exp(phi + d) = exp(phi) exp(J d): Barfoot, State Estimation for Robotics, 2017, Eq. 7.77.
Matrix3d right_jacobian(const Vector3d& phi) {
  const double angle = phi.norm();
  const Matrix3d K = skew(phi);
  if (angle < kSmallAngle) return Matrix3d::Identity() - 0.5 * K + K * K / 6;
  const double a2 = angle * angle;
  return Matrix3d::Identity() - 2 * std::pow(std::sin(angle / 2), 2) / a2 * K +
         (angle - std::sin(angle)) / (a2 * angle) * K * K;
}

double seconds(std::int64_t ns) {
  return static_cast<double>(ns) * 1e-9;
}

Vector3d turn_rate(const LidarState& state, const InertialReading& reading) {
  return reading.angular_velocity_radps - state.gyroscope_bias_radps;
}

// Acceleration in the body, gravity aside.
Vector3d own_acceleration(const LidarState& state, const InertialReading& reading) {
  return reading.specific_force_mps2 - state.accelerometer_bias_mps2;
}

// Of a point in the world's axes, from the body at the end.
Vector3d moved_on(const LidarState& end, const SweepPoint& point, const Vector3d& turned) {
  return turned + end.world_from_body.translation - point.age_s * end.velocity_mps + point.bend_m;
}

}  // namespace

LidarState moved(const LidarState& state, const Vector18d& error) {
  LidarState result = state;
  result.world_from_body.rotation =
      (state.world_from_body.rotation * exp_so3(error.segment<3>(kTurn))).normalized();
  result.world_from_body.translation += error.segment<3>(kPlace);
  result.velocity_mps += error.segment<3>(kVelocity);
  result.gyroscope_bias_radps += error.segment<3>(kGyroscope);
  result.accelerometer_bias_mps2 += error.segment<3>(kAccelerometer);
  result.gravity_mps2 += error.segment<3>(kGravity);
  return result;
}

Vector18d difference(const LidarState& a, const LidarState& b) {
  Vector18d error;
  error << log_so3(b.world_from_body.rotation.conjugate() * a.world_from_body.rotation),
      a.world_from_body.translation - b.world_from_body.translation, a.velocity_mps - b.velocity_mps,
      a.gyroscope_bias_radps - b.gyroscope_bias_radps, a.accelerometer_bias_mps2 - b.accelerometer_bias_mps2,
      a.gravity_mps2 - b.gravity_mps2;
  return error;
}

LidarState propagated(const LidarState& state, const InertialReading& reading, std::int64_t to_ns) {
  const double dt = seconds(to_ns - state.stamp_ns);
  const Eigen::Quaterniond& R = state.world_from_body.rotation;
  const Vector3d acceleration = R * own_acceleration(state, reading) + state.gravity_mps2;
  LidarState result = state;
  result.stamp_ns = to_ns;
  result.world_from_body.rotation = (R * exp_so3(dt * turn_rate(state, reading))).normalized();
  result.world_from_body.translation += dt * state.velocity_mps + 0.5 * dt * dt * acceleration;
  result.velocity_mps += dt * acceleration;
  return result;
}

Matrix18d propagation_jacobian(const LidarState& state, const InertialReading& reading, std::int64_t to_ns) {
  const double dt = seconds(to_ns - state.stamp_ns);
  const Matrix3d R = state.world_from_body.rotation.toRotationMatrix();
  const Matrix3d by_turn = -R * skew(own_acceleration(state, reading));
  const Vector3d turn = dt * turn_rate(state, reading);
  Matrix18d F = Matrix18d::Identity();
  F.block<3, 3>(kTurn, kTurn) = exp_so3(-turn).toRotationMatrix();
  F.block<3, 3>(kTurn, kGyroscope) = -dt * right_jacobian(turn);
  F.block<3, 3>(kPlace, kTurn) = 0.5 * dt * dt * by_turn;
  F.block<3, 3>(kPlace, kVelocity) = dt * Matrix3d::Identity();
  F.block<3, 3>(kPlace, kAccelerometer) = -0.5 * dt * dt * R;
  F.block<3, 3>(kPlace, kGravity) = 0.5 * dt * dt * Matrix3d::Identity();
  F.block<3, 3>(kVelocity, kTurn) = dt * by_turn;
  F.block<3, 3>(kVelocity, kAccelerometer) = -dt * R;
  F.block<3, 3>(kVelocity, kGravity) = dt * Matrix3d::Identity();
  return F;
}

// White noise of the accelerometer is white in the velocity and integrates to the place, that of the
// gyroscope's walk to the turn.
Matrix18d propagation_noise(const InertialNoise& noise, double dt) {
  const auto square = [](double x) { return x * x; };
  const double gyroscope = square(noise.gyroscope) * dt, walk = square(noise.gyroscope_walk) * dt;
  const double force = square(noise.accelerometer) * dt;
  Vector18d diagonal = Vector18d::Zero();
  diagonal.segment<3>(kTurn).setConstant(gyroscope + walk * dt * dt / 3);
  diagonal.segment<3>(kPlace).setConstant(force * dt * dt / 3);
  diagonal.segment<3>(kVelocity).setConstant(force);
  diagonal.segment<3>(kGyroscope).setConstant(walk);
  diagonal.segment<3>(kAccelerometer).setConstant(square(noise.accelerometer_walk) * dt);
  Matrix18d Q = diagonal.asDiagonal();
  for (int k = 0; k < 3; ++k) {
    Q(kPlace + k, kVelocity + k) = Q(kVelocity + k, kPlace + k) = force * dt / 2;
    Q(kTurn + k, kGyroscope + k) = Q(kGyroscope + k, kTurn + k) = -walk * dt / 2;
  }
  return Q;
}

EndPoint end_point(const LidarState& end, const Vector3d& path_bias, const SweepPoint& point) {
  const Vector3d turn = point.age_s * (end.gyroscope_bias_radps - path_bias);
  const Eigen::Quaterniond turned = exp_so3(turn);
  return {turn, turned, point.end_from_then * (turned * point.body)};
}

Vector3d world_point(const LidarState& end, const SweepPoint& point, const EndPoint& at_end) {
  return moved_on(end, point, end.world_from_body.rotation * at_end.body);
}

double plane_distance(const LidarState& end, const SweepPoint& point, const EndPoint& at_end,
                      const MapPlane& plane) {
  // a matrix, not world_point()'s quaternion: results keep their last digits
  const Vector3d world = moved_on(end, point, end.world_from_body.rotation.toRotationMatrix() * at_end.body);
  return plane.normal.dot(world) + plane.offset_m;
}

Row12d distance_jacobian(const LidarState& end, const SweepPoint& point, const EndPoint& at_end,
                         const Vector3d& normal) {
  const Vector3d n_end = end.world_from_body.rotation.toRotationMatrix().transpose() * normal;
  const Vector3d n_then = at_end.turned.conjugate() * (point.end_from_then.transpose() * n_end);
  Row12d row;
  row.segment<3>(kTurn) = at_end.body.cross(n_end).transpose();
  row.segment<3>(kPlace) = normal.transpose();
  row.segment<3>(kVelocity) = -point.age_s * normal.transpose();
  row.segment<3>(kGyroscope) =
      point.age_s * point.body.cross(n_then).transpose() * right_jacobian(at_end.turn_rad);
  return row;
}

LidarBelief propagated(const LidarBelief& belief, const InertialReading& reading, const InertialNoise& noise,
                       std::int64_t to_ns) {
  const Matrix18d F = propagation_jacobian(belief.state, reading, to_ns);
  const double dt = seconds(to_ns - belief.state.stamp_ns);
  return {propagated(belief.state, reading, to_ns),
          F * belief.covariance * F.transpose() + propagation_noise(noise, dt)};
}

LidarBelief with_gravity(const LidarBelief& belief, double magnitude_mps2) {
  const double found_mps2 = belief.state.gravity_mps2.norm();
  if (found_mps2 == 0) return belief;
  const Vector3d down = belief.state.gravity_mps2 / found_mps2;
  LidarBelief result = belief;
  result.state.gravity_mps2 = magnitude_mps2 * down;
  Matrix18d by_error = Matrix18d::Identity();
  by_error.block<3, 3>(kGravity, kGravity) =
      magnitude_mps2 / found_mps2 * (Matrix3d::Identity() - down * down.transpose());
  result.covariance = by_error * belief.covariance * by_error.transpose();
  return result;
}

// At an iterate x the prior is of mean -e and covariance P in x's own error d, whose logarithm from the prior
// is bent by the rotation's Jacobian. With the points' sums M and b, (P^-1 + M) d = -P^-1 e - b, so
// (I + P M) d = -(e + P b), and (I + P M)^-1 P is the covariance afterwards.
LidarBelief updated(const LidarBelief& prior,
                    const std::function<LidarNormal(const LidarState&, int iteration)>& normal_at,
                    int max_iterations) {
  LidarBelief result = prior;
  for (int i = 0; i < max_iterations; ++i) {
    const LidarNormal normal = normal_at(result.state, i);
    if (normal.points == 0) return prior;
    const Vector18d off = difference(result.state, prior.state);
    Matrix18d bend = Matrix18d::Identity();
    bend.block<3, 3>(kTurn, kTurn) = right_jacobian(off.segment<3>(kTurn));  // inverse of d off / d error
    const Matrix18d P = bend * prior.covariance * bend.transpose();
    Matrix18d system = Matrix18d::Identity();
    system.leftCols<kSightingDof>() += P.leftCols<kSightingDof>() * normal.square;
    const Eigen::PartialPivLU<Matrix18d> solver(system);
    const Vector18d step = -solver.solve(bend * off + P.leftCols<kSightingDof>() * normal.side);
    result.state = moved(result.state, step);
    const Matrix18d covariance = solver.solve(P);
    result.covariance = 0.5 * (covariance + covariance.transpose());
    if (step.segment<3>(kTurn).norm() < kStepTurn_rad && step.segment<3>(kPlace).norm() < kStepShift_m) break;
  }
  return result;
}

}  // namespace uniquadric
