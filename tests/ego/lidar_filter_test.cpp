#include "estimator/ego/lidar_filter.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <numbers>
#include <vector>

#include "core/base/random.h"
#include "estimator/ego/lidar_observability.h"

namespace uniquadric {
namespace {

using Eigen::Vector3d;

Vector3d random_vector(RandomStream& random, double scale) {
  return scale * Vector3d(random.normal(), random.normal(), random.normal());
}

LidarState random_state(RandomStream& random, double angle_rad) {
  LidarState state;
  state.stamp_ns = 5'000'000'000;
  state.world_from_body = {exp_so3(angle_rad * random_vector(random, 1).normalized()),
                           random_vector(random, 3)};
  state.velocity_mps = random_vector(random, 2);
  state.gyroscope_bias_radps = random_vector(random, 0.3);
  state.accelerometer_bias_mps2 = random_vector(random, 0.2);
  state.gravity_mps2 = {0.1, -0.2, -9.8};
  return state;
}

constexpr double kStep = 1e-6;
constexpr double kJacobianTolerance =
    1e-7;  // central differences of step 1e-6: 1e-12 of curvature, 1e-10 of rounding
const std::vector<double> kAngles = {0, 1e-7, 0.8, std::numbers::pi - 1e-6};

TEST(LidarFilter, MovedAndDifferenceAreInverse) {
  RandomStream random(1, "filter");
  for (const double angle : kAngles) {
    const LidarState state = random_state(random, angle);
    Vector18d error;
    for (int k = 0; k < kLidarDof; ++k) error[k] = 0.4 * random.normal();
    EXPECT_LT((difference(moved(state, error), state) - error).norm(), 1e-12);
  }
}

TEST(LidarFilter, PropagationJacobianIsTheDifference) {
  RandomStream random(2, "filter");
  for (const double angle : kAngles)
    for (const std::int64_t dt_ns : {1'000'000, 100'000'000}) {
      const LidarState state = random_state(random, angle);
      const InertialReading reading{random_vector(random, 1), random_vector(random, 5)};
      const std::int64_t to_ns = state.stamp_ns + dt_ns;
      const LidarState mean = propagated(state, reading, to_ns);
      const Matrix18d F = propagation_jacobian(state, reading, to_ns);
      for (int k = 0; k < kLidarDof; ++k) {
        const Vector18d step = kStep * Vector18d::Unit(k);
        const Vector18d numeric = (difference(propagated(moved(state, step), reading, to_ns), mean) -
                                   difference(propagated(moved(state, -step), reading, to_ns), mean)) /
                                  (2 * kStep);
        EXPECT_LT((F.col(k) - numeric).norm(), kJacobianTolerance) << k;
      }
    }
}

TEST(LidarFilter, PlaneDistanceJacobianIsTheDifference) {
  RandomStream random(3, "filter");
  for (const double angle : kAngles)
    for (const double bias_change : {0.0, 0.5}) {
      const LidarState state = random_state(random, angle);
      const Vector3d path_bias = state.gyroscope_bias_radps + random_vector(random, bias_change);
      const SweepPoint point{random_vector(random, 10),
                             exp_so3(random_vector(random, 0.1)).toRotationMatrix(),
                             random_vector(random, 0.1), 0.07};
      const MapPlane plane{random_vector(random, 1).normalized(), 2.5, 0};
      const auto distance = [&](const LidarState& end) {
        return plane_distance(end, point, end_point(end, path_bias, point), plane);
      };
      const Row12d J = distance_jacobian(state, point, end_point(state, path_bias, point), plane.normal);
      for (int k = 0; k < kSightingDof; ++k) {
        const Vector18d step = kStep * Vector18d::Unit(k);
        const double numeric = (distance(moved(state, step)) - distance(moved(state, -step))) / (2 * kStep);
        EXPECT_NEAR(J[k], numeric, 1e-6) << k;  // the point is ten metres away
      }
    }
}

TEST(LidarFilter, PlaneDistanceIsThatOfTheWorldPoint) {
  RandomStream random(4, "filter");
  const LidarState state = random_state(random, 1);
  const SweepPoint point{random_vector(random, 10), exp_so3(random_vector(random, 0.1)).toRotationMatrix(),
                         random_vector(random, 0.1), 0.05};
  const MapPlane plane{random_vector(random, 1).normalized(), -1.5, 0};
  const Vector3d bias = state.gyroscope_bias_radps + Vector3d(0.1, 0, 0.2);
  const EndPoint at_end = end_point(state, bias, point);
  EXPECT_NEAR(plane_distance(state, point, at_end, plane),
              plane.normal.dot(world_point(state, point, at_end)) + plane.offset_m, 1e-12);
}

TEST(LidarFilter, WithoutReadingsItMovesAtConstantVelocity) {
  RandomStream random(5, "filter");
  LidarState state = random_state(random, 0.5);
  state.accelerometer_bias_mps2 = state.gravity_mps2 = Vector3d::Zero();
  const LidarState later = propagated(state, {}, state.stamp_ns + 2'000'000'000);
  const Pose& a = state.world_from_body;
  EXPECT_LT((later.world_from_body.translation - a.translation - 2 * state.velocity_mps).norm(), 1e-12);
  EXPECT_LT(log_so3(later.world_from_body.rotation.conjugate() *
                    (a.rotation * exp_so3(-2 * state.gyroscope_bias_radps)))
                .norm(),
            1e-12);
  EXPECT_EQ(later.velocity_mps, state.velocity_mps);
}

TEST(LidarFilter, AtRestGravityAndForceCancel) {
  LidarState state;
  state.world_from_body.rotation = exp_so3({0.2, -0.4, 0.1});
  state.gravity_mps2 = {0, 0, -9.81};
  const InertialReading reading{Vector3d::Zero(),
                                state.world_from_body.rotation.conjugate() * Vector3d(0, 0, 9.81)};
  const LidarState later = propagated(state, reading, 1'000'000'000);
  EXPECT_LT(later.velocity_mps.norm(), 1e-12);
  EXPECT_LT(later.world_from_body.translation.norm(), 1e-12);
}

// A second way: noise driven through many small steps.
TEST(LidarFilter, NoiseOfOneStepIsThatOfManySmallOnes) {
  const InertialNoise noise{0.1, 0.3, 0.7, 0};
  LidarBelief whole, fine;
  whole = propagated(whole, {}, noise, 100'000'000);
  for (int i = 1; i <= 1000; ++i) fine = propagated(fine, {}, noise, i * 100'000);
  EXPECT_LT((whole.covariance - fine.covariance).norm(), 1e-5 * fine.covariance.norm());
}

// Where nothing turns the body, the update is linear least squares, solved here in information form.
TEST(LidarFilter, UpdateIsLeastSquares) {
  RandomStream random(6, "filter");
  LidarBelief prior;
  prior.state = random_state(random, 0.3);
  Matrix18d L;
  for (int i = 0; i < kLidarDof; ++i)
    for (int k = 0; k < kLidarDof; ++k) L(i, k) = 0.1 * random.normal();
  prior.covariance = L * L.transpose() + 0.01 * Matrix18d::Identity();
  prior.covariance.topRightCorner<3, 15>().setZero();
  prior.covariance.bottomLeftCorner<15, 3>().setZero();
  Eigen::Matrix<double, 9, 1> target;  // of place, velocity, bias
  for (int k = 0; k < 9; ++k) target[k] = 0.2 * random.normal();
  Eigen::Matrix<double, 9, 9> A;
  for (int k = 0; k < 81; ++k) A.data()[k] = random.normal();
  const auto normal_at = [&](const LidarState& state, int) {
    LidarNormal normal;
    normal.points = 1;
    normal.square.bottomRightCorner<9, 9>() = A.transpose() * A;
    normal.side.tail<9>() = A.transpose() * A * (difference(state, prior.state).segment<9>(kPlace) - target);
    return normal;
  };
  const LidarBelief after = updated(prior, normal_at, 10);
  Matrix18d information = prior.covariance.inverse();
  information.block<9, 9>(kPlace, kPlace) += A.transpose() * A;
  Vector18d side = Vector18d::Zero();
  side.segment<9>(kPlace) = A.transpose() * A * target;
  EXPECT_LT((difference(after.state, prior.state) - information.inverse() * side).norm(), 1e-9);
  EXPECT_LT((after.covariance - information.inverse()).norm(), 1e-9 * after.covariance.norm());
}

TEST(LidarFilter, WithoutPointsTheBeliefStays) {
  RandomStream random(7, "filter");
  LidarBelief prior;
  prior.state = random_state(random, 1);
  prior.covariance = 0.1 * Matrix18d::Identity();
  const LidarBelief after = updated(
      prior, [](const LidarState&, int) { return LidarNormal(); }, 5);
  EXPECT_EQ(difference(after.state, prior.state).norm(), 0);
  EXPECT_EQ(after.covariance, prior.covariance);
}

TEST(LidarFilter, GravityIsAsStrongAsItIsKnownToBe) {
  LidarBelief belief;
  belief.state.gravity_mps2 = {1, 0, -9.81};
  belief.covariance.block<3, 3>(kGravity, kGravity).diagonal() << 0.25, 0.25, 1;
  const LidarBelief found = with_gravity(belief, 9.81);
  EXPECT_NEAR(found.state.gravity_mps2.norm(), 9.81, 1e-12);
  const Vector3d g = belief.state.gravity_mps2.normalized();
  EXPECT_NEAR(g.dot(found.covariance.block<3, 3>(kGravity, kGravity) * g), 0, 1e-12);  // along it known
  const double shrunk = 9.81 / belief.state.gravity_mps2.norm();  // a direction's error is an angle
  EXPECT_NEAR(found.covariance(kGravity + 1, kGravity + 1), 0.25 * shrunk * shrunk, 1e-12);
  belief.state.gravity_mps2.setZero();
  EXPECT_EQ(with_gravity(belief, 9.81).covariance, belief.covariance);
}

}  // namespace
}  // namespace uniquadric
