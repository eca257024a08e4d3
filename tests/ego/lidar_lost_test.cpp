// Where too little is seen to say where the LiDAR is.
#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

#include "core/base/random.h"
#include "estimator/ego/lidar_observability.h"
#include "tests/ego/room_run.h"

namespace uniquadric {
namespace {

using Eigen::Vector3d;

// The mechanism alone: no pass ends as it began to the last nanometre, so there is no start, nor a pose.
TEST(LidarOdometry, AStartWhoseMotionStillChangesIsPutOff) {
  RoomRun run;
  run.scans = 25;
  run.room.range_sigma_m = 0.02;
  run.options.first_change_mps = 1e-9;
  const LidarOdometry odometry = run.odometry();
  EXPECT_TRUE(odometry.reports().empty());
  EXPECT_EQ(errors_of(odometry, run).poses, 0);
}

// Where the map is met again it is found, or else it stays lost: never elsewhere.
TEST(LidarOdometry, AfterLongWithoutScansItIsFoundAtItsPlaceOrLost) {
  for (const int back : {22, 28, 34}) {
    RoomRun run;
    run.has_imu = false;
    run.scans = back + 8;
    run.room.range_sigma_m = 0.02;
    run.is_dropped = [&](int scan) { return scan >= 15 && scan < back; };
    const LidarOdometry odometry = run.odometry();
    const bool is_short = back == 22;  // known within half a metre until then
    const double end_s = run.scans / run.room.rate_hz;
    const auto first = odometry.world_from_camera(0),
               last = odometry.world_from_camera(std::llround(1e9 * end_s));
    ASSERT_TRUE(first) << back;
    EXPECT_TRUE(last || !is_short);
    if (!last) continue;
    const Pose truth = relative_pose(run.room.world_from_lidar(0), run.room.world_from_lidar(end_s));
    EXPECT_LT((relative_pose(*first, *last).translation - truth.translation).norm(), 0.1) << back;
  }
}

// A tunnel and a floor under a ceiling, without an end: neither noise of planes' normals nor rings, which go
// along with the sensor, must feign to tell what nothing tells.
TEST(LidarOdometry, WhereNothingTellsAMotionItDoesNotBegin) {
  using Pattern = LidarRoom::Pattern;
  for (const auto& [pattern, speed, width_m] :
       {std::tuple(Pattern::forward, 2.0, 2.5), {Pattern::rings, 10.0, 4.0}, {Pattern::spinning, 2.0, 500.0}})
    for (const bool has_imu : {true, false}) {
      RoomRun run;
      run.scans = 20;
      run.room.points = 6'000;
      run.has_imu = has_imu;
      run.room.pattern = pattern;
      run.room.range_sigma_m = 0.02;
      run.room.vigour = 0.3;
      run.room.is_bare = true;
      run.room.half_size_m = {500, width_m, 2};
      run.room.max_range_m = 60;
      run.room.velocity_mps = {speed, 0, 0};
      const LidarOdometry odometry = run.odometry();
      for (int scan = 0; scan <= run.scans; ++scan)
        EXPECT_FALSE(odometry.world_from_camera(run.room.scan_start_ns(scan))) << speed << has_imu << scan;
    }
}

// Backwards into a tunnel, away from a wall that is soon out of range. In what is told it stays exact.
TEST(LidarOdometry, WhatNothingTellsAnyMoreIsUncertainAndThenLost) {
  int lost = 0;
  for (const bool has_imu : {true, false}) {
    RoomRun run;
    run.scans = 50;
    run.has_imu = has_imu;
    run.room.pattern = LidarRoom::Pattern::forward;
    run.room.range_sigma_m = 0.02;
    run.room.vigour = 0.3;
    run.room.is_bare = true;
    run.room.half_size_m = {45, 2.5, 2};
    run.room.max_range_m = 52;
    run.room.velocity_mps = {-5, 0, 0};
    const LidarOdometry odometry = run.odometry();
    const auto first = odometry.world_from_camera(0);
    ASSERT_TRUE(first) << has_imu;
    for (const SweepReport& report : odometry.reports()) {
      const auto pose = odometry.world_from_camera(report.end_ns);
      lost += !pose;
      if (!pose) continue;
      const Pose truth = run.room.world_from_lidar(1e-9 * static_cast<double>(report.end_ns));
      const Vector3d off =
          (run.room.world_from_lidar(0) * first->inverse() * *pose).translation - truth.translation;
      const Vector3d sigma_m = report.place_covariance_m2.diagonal().cwiseSqrt();
      EXPECT_LT(std::abs(off.x()), 5 * sigma_m.x() + 0.2) << has_imu << report.end_ns;
      EXPECT_LT(off.tail<2>().cwiseAbs().maxCoeff(), 0.03) << has_imu << report.end_ns;
    }
  }
  EXPECT_GT(lost, 10);
}

TEST(LidarOdometry, IsLostWhenNothingIsSeenForLong) {
  RoomRun run;
  run.has_imu = false;
  run.is_dropped = [](int scan) { return scan >= 15; };
  const LidarOdometry odometry = run.odometry();
  EXPECT_TRUE(odometry.world_from_camera(1'000'000'000));
  EXPECT_FALSE(odometry.world_from_camera(3'900'000'000));
}

TEST(LidarOdometry, NoPointsNoPoses) {
  RoomRun run;
  run.scans = 12;
  run.change = [](int, std::vector<LidarPoint>& points) { points.clear(); };
  EXPECT_FALSE(run.odometry().world_from_camera(500'000'000));
  LidarOdometry nothing(LidarRigView(), {}, {});
  nothing.finish();
  EXPECT_FALSE(nothing.world_from_camera(0));
}

// The second way: the bend as parameters of its own in one least-squares problem.
TEST(LidarObservability, ABentMapIsAnErrorOfItsOwn) {
  RandomStream random(6, "bend");
  const double bend_mps = 0.3, bend_radps = 0.1;
  Eigen::Matrix<double, 18, 18> square = Eigen::Matrix<double, 18, 18>::Zero();
  Eigen::Matrix<double, 18, 1> side = Eigen::Matrix<double, 18, 1>::Zero();
  LidarNormal normal;
  for (int i = 0; i < 50; ++i) {
    Eigen::Matrix<double, 1, 18> row;
    for (int k = 0; k < kSightingDof; ++k) row[k] = random.normal();
    row.tail<6>() = row.segment<6>(kVelocity);
    const double residual = random.normal();
    square += row.transpose() * row;
    side += residual * row.transpose();
    normal.square += row.head<kSightingDof>().transpose() * row.head<kSightingDof>();
    normal.side += residual * row.head<kSightingDof>().transpose();
    ++normal.points;
  }
  square.diagonal().tail<6>() +=
      (Eigen::Matrix<double, 6, 1>() << Vector3d::Constant(1 / (bend_mps * bend_mps)),
       Vector3d::Constant(1 / (bend_radps * bend_radps)))
          .finished();
  const LidarNormal told = with_bent_map(normal, bend_mps, bend_radps);
  // Their sums do not tell velocity from bend but by the prior of both: as the filter's covariance, here 1.
  const SightingSquare known = SightingSquare::Identity();
  square.topLeftCorner<kSightingDof, kSightingDof>() += known;
  const Eigen::Matrix<double, 18, 1> both = square.ldlt().solve(side);
  const Eigen::Matrix<double, kSightingDof, 1> step = (told.square + known).ldlt().solve(told.side);
  EXPECT_LT((step - both.head<kSightingDof>()).norm(), 1e-10);
  EXPECT_EQ(told.points, normal.points);
}

TEST(LidarObservability, NoiseOfNormalsTellsNothingAndFacingPlanesDo) {
  // along z a hundred planes tell, along y ten, along x noise alone
  LidarNormal normal;
  normal.points = 110;
  normal.square.block<3, 3>(kTurn, kTurn).diagonal() << 5, 100, 100;
  normal.square.block<3, 3>(kPlace, kPlace).diagonal() << 2, 10, 100;
  normal.square.block<3, 3>(kVelocity, kVelocity).diagonal() << 2, 10, 100;
  normal.side.setOnes();
  SightingSquare noise = SightingSquare::Zero();
  noise.diagonal().setConstant(1);
  std::vector<Vector3d> normals(100, Vector3d::UnitZ());
  normals.insert(normals.end(), 10, Vector3d(0, 0.8, 0.6));
  const LidarNormal told = without_feigned(normal, noise, normals, {});
  EXPECT_EQ(told.points, 110);
  const auto expected_side = [&](int part, const Vector3d& side) {
    EXPECT_LT((told.side.segment<3>(part) - side).norm(), 1e-12) << part;
  };
  expected_side(kTurn, {0, 1, 1});
  expected_side(kGyroscope, {0, 1, 1});
  expected_side(kPlace, {0, 1, 1});
  expected_side(kVelocity, {0, 1, 1});
  EXPECT_NEAR((told.square.block<3, 3>(kPlace, kPlace)(0, 0)), 0, 1e-12);
  EXPECT_NEAR((told.square.block<3, 3>(kPlace, kPlace)(1, 1)), 10, 1e-12);
  normals.resize(105);  // five that face y are too few
  EXPECT_NEAR((without_feigned(normal, noise, normals, {}).square(kPlace + 1, kPlace + 1)), 0, 1e-12);
}

}  // namespace
}  // namespace uniquadric
