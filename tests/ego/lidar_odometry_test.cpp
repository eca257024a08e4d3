#include "estimator/ego/lidar_odometry.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/ego/room_run.h"

namespace uniquadric {
namespace {

using Eigen::Vector3d;

// A VLP-16's rings and noise, in a room as large.
RoomRun run_of_rings(const Vector3d& half_size_m, double speed_mps, int points = 20'000) {
  RoomRun run;
  run.room.pattern = LidarRoom::Pattern::rings;
  run.room.half_size_m = half_size_m;
  run.room.velocity_mps = {speed_mps, 0, 0};
  run.room.range_sigma_m = 0.03;
  run.room.points = points;
  run.noise = {.range_sigma_m = 0.03, .divergence_deg = 0.28, .angle_sigma_deg = 0};
  return run;
}

TEST(LidarOdometry, FollowsASpinningLidarThroughARoom) {
  RoomRun run;
  run.room.range_sigma_m = 0.02;
  const RoomErrors errors = errors_of(run.odometry(), run);
  EXPECT_EQ(errors.missing, 0);
  EXPECT_LT(errors.max_m, 0.02);
  EXPECT_LT(errors.max_rad, 0.004);
}

TEST(LidarOdometry, FollowsItAtConstantVelocity) {
  RoomRun run;
  run.has_imu = false;
  run.room.range_sigma_m = 0.02;
  const RoomErrors errors = errors_of(run.odometry(), run);
  EXPECT_EQ(errors.missing, 0);
  EXPECT_LT(errors.max_m, 0.03);
  EXPECT_LT(errors.max_rad, 0.01);
}

TEST(LidarOdometry, FollowsANarrowRosette) {
  RoomRun run;
  run.room.pattern = LidarRoom::Pattern::forward;
  run.room.range_sigma_m = 0.02;
  run.room.points = 10'000;
  const RoomErrors errors = errors_of(run.odometry(), run);
  EXPECT_EQ(errors.missing, 0);
  EXPECT_LT(errors.max_m, 0.05);
  EXPECT_LT(errors.max_rad, 0.01);
}

// Walls 12 m away and more, on which two rings lie 0.4 m and more apart: the points of one are a line, and
// noise makes a plane of it that goes along with the sensor.
TEST(LidarOdometry, FollowsSixteenRingsThroughAHall) {
  for (const bool has_imu : {true, false}) {
    RoomRun run = run_of_rings({20, 12, 3}, 1.2);
    run.has_imu = has_imu;
    run.room.vigour = 0.3;
    const RoomErrors errors = errors_of(run.odometry(), run);
    EXPECT_EQ(errors.missing, 0);
    EXPECT_LT(errors.max_m, 0.01 * 1.2 * 4);
    EXPECT_LT(errors.max_rad, 0.01);
  }
}

// A ring that goes round piers lies in a plane, which a tilted sensor takes along with it: 7.5 m off of 7.5
// m. What is left tells so little that the start may be waited for.
TEST(LidarOdometry, FollowsSixteenTiltedRingsPastPiers) {
  for (const bool has_imu : {true, false}) {
    RoomRun run = run_of_rings({60, 12, 4}, 3, 28'000);
    run.scans = 25;
    run.has_imu = has_imu;
    run.room.has_piers = true;
    run.room.tilt_rad = 0.26;
    run.room.vigour = 0.05;
    const RoomErrors errors = errors_of(run.odometry(), run);
    EXPECT_GT(errors.poses, 25) << has_imu;
    EXPECT_LT(errors.max_m, 0.25) << has_imu;
    EXPECT_LT(errors.max_rad, 0.01) << has_imu;
  }
}

TEST(LidarOdometry, TheGroundLevelsTheWorldWithoutAnImu) {
  RoomRun run;
  run.scans = 12;
  run.has_imu = false;
  run.room.tilt_rad = 0.3;
  run.room.half_size_m = {7, 5, 1.5};  // floor and ceiling are its largest sides, as seen
  run.room.range_sigma_m = 0.02;
  const LidarOdometry odometry = run.odometry();
  const auto pose = odometry.world_from_camera(run.room.start_ns);  // the camera is the sensor
  ASSERT_TRUE(pose);
  const Pose truth = run.room.world_from_lidar(0);
  EXPECT_LT((pose->rotation.conjugate() * Vector3d::UnitZ() - truth.rotation.conjugate() * Vector3d::UnitZ())
                .norm(),
            0.02);
}

// The same of one that hangs upside down beside a camera that does not.
TEST(LidarOdometry, ALidarUpsideDownIsToldByItsCamera) {
  RoomRun run;
  run.scans = 12;
  run.has_imu = false;
  run.room.half_size_m = {7, 5, 1.5};
  run.room.range_sigma_m = 0.02;
  Eigen::Matrix3d R;  // of the camera's axes (right, down, forward), the LiDAR's z being down
  R << 0, 1, 0, 0, 0, 1, 1, 0, 0;
  run.camera_from_lidar.rotation = Eigen::Quaterniond(R);
  const LidarOdometry odometry = run.odometry();
  const auto pose = odometry.world_from_camera(run.room.start_ns);
  ASSERT_TRUE(pose);
  EXPECT_LT((pose->rotation * -Vector3d::UnitY() - Vector3d::UnitZ()).norm(), 0.2);  // it sways by 0.1 rad
}

// Rings on floor and walls stand still beside a sensor that moves along them; only the cupboards tell.
TEST(LidarOdometry, BeginsAtTheSpeedOfACar) {
  for (const double speed : {0.0, 6.0, 18.0})
    for (const bool has_imu : {true, false}) {
      RoomRun run = run_of_rings({60, 9, 3}, speed);
      run.scans = 20;
      run.has_imu = has_imu;
      run.room.max_range_m = 35;
      run.room.vigour = 0.2;
      const RoomErrors errors = errors_of(run.odometry(), run);
      EXPECT_EQ(errors.missing, 0) << speed << has_imu;
      EXPECT_LT(errors.max_m, 0.05 + 0.01 * speed * 2) << speed << has_imu;
    }
}

// A mean force leans by half a g here, and says that the world does.
TEST(LidarOdometry, AStartUnderAccelerationLeavesTheWorldLevel) {
  for (const double braking : {3.0, 5.0}) {
    RoomRun run = run_of_rings({60, 9, 3}, 2.5 * braking);
    run.scans = 20;
    run.room.vigour = 0.2;
    run.room.velocity_mps.x() -= 10;
    run.room.acceleration_mps2.x() = -braking;
    const LidarOdometry odometry = run.odometry();
    const RoomErrors errors = errors_of(odometry, run);
    EXPECT_EQ(errors.missing, 0) << braking;
    EXPECT_LT(errors.max_m, 0.1) << braking;
    const auto pose = odometry.world_from_camera(run.room.start_ns);
    ASSERT_TRUE(pose) << braking;
    const Pose truth = run.room.world_from_lidar(0);
    EXPECT_LT(
        (pose->rotation.conjugate() * Vector3d::UnitZ() - truth.rotation.conjugate() * Vector3d::UnitZ())
            .norm(),
        0.01)
        << braking;
  }
}

TEST(LidarOdometry, ForcesWithoutGravityAreLeftOut) {
  LidarRigView rig;
  rig.imu = ImuCalibration();
  const std::vector<ImuSample> samples = LidarRoom().imu(0.1);
  EXPECT_EQ(lidar_setting(rig, samples, {}).imu.front().specific_force_mps2,
            samples.front().specific_force_mps2);
  rig.imu->gravity_mps2 = 0;
  const LidarSetting setting = lidar_setting(rig, samples, {});
  EXPECT_EQ(setting.imu.front().specific_force_mps2, Vector3d::Zero());
  EXPECT_EQ(setting.imu.front().angular_velocity_radps, samples.front().angular_velocity_radps);
}

TEST(LidarOdometry, FindsTheBiasesOfItsImu) {
  RoomRun run;
  run.room.gyroscope_bias_radps = {0.01, -0.02, 0.015};
  run.room.accelerometer_bias_mps2 = {0.05, 0.03, -0.04};
  run.room.range_sigma_m = 0.01;
  const RoomErrors errors = errors_of(run.odometry(), run);
  EXPECT_LT(errors.max_m, 0.02);
  EXPECT_LT(errors.max_rad, 0.005);
}

TEST(LidarOdometry, TheImuCarriesItThroughASecondWithoutScans) {
  RoomRun run;
  run.room.range_sigma_m = 0.02;
  run.is_dropped = [](int scan) { return scan >= 20 && scan < 30; };
  const RoomErrors errors = errors_of(run.odometry(), run);
  EXPECT_EQ(errors.missing, 0);
  EXPECT_LT(errors.max_m, 0.08);
  EXPECT_LT(errors.max_rad, 0.006);
}

// A reading that is held for good tells nothing of the motion (3.8 m off), the scans do.
TEST(LidarOdometry, AnImuThatEndsLeavesTheScansToTell) {
  RoomRun run;
  run.room.range_sigma_m = 0.02;
  run.change_imu = [](auto& samples) { samples.resize(samples.size() * 3 / 8); };
  const RoomErrors errors = errors_of(run.odometry(), run);
  EXPECT_EQ(errors.missing, 0);
  EXPECT_LT(errors.max_m, 0.15);
  EXPECT_LT(errors.max_rad, 0.06);
}

// Ranges as noisy as 0.15 m: to a sensor that is thought to be good to 0.02 m no wall is thin enough to be
// one.
TEST(LidarOdometry, ANoisySensorIsFollowedByItsDataSheet) {
  RoomRun run;
  run.scans = 20;
  run.room.range_sigma_m = 0.15;
  const auto on_planes = [&] {
    const LidarOdometry odometry = run.odometry();
    double share = 0;
    for (const SweepReport& report : odometry.reports()) share = std::max(share, 1.0 * report.on_planes);
    return share;
  };
  const double unknown = on_planes();
  run.noise.range_sigma_m = 0.15;
  EXPECT_GT(on_planes(), 3 * unknown);
  const RoomErrors errors = errors_of(run.odometry(), run);
  EXPECT_EQ(errors.missing, 0);
  EXPECT_LT(errors.max_m, 0.15);
  run.options.sight.range_sigma_m = 0.02;  // the variant overrides the sensor
  EXPECT_LE(on_planes(), 1.5 * unknown);
}

TEST(LidarOdometry, SigmasAreTheOptionsOrElseTheSensors) {
  const LidarDataSheet mid40{.range_sigma_m = 0.02, .divergence_deg = 0.28, .angle_sigma_deg = 0.1};
  LidarSightOptions options;
  EXPECT_EQ(point_sigmas(options, mid40).range_m, 0.02);
  // 0.1 deg, and 0.28 deg evenly: 1.7453 mrad, 1.4107 mrad
  EXPECT_NEAR(point_sigmas(options, mid40).beam_rad, 2.2442e-3, 1e-7);
  options.beam_sigma_rad = 0.003;
  options.range_sigma_m = 0.05;
  EXPECT_EQ(point_sigmas(options, mid40).beam_rad, 0.003);
  EXPECT_EQ(point_sigmas(options, mid40).range_m, 0.05);
  EXPECT_GT(point_sigmas({}, {0, 0, 0}).range_m, 0);  // an exact sensor's walls are not thinner than nothing
}

// Points of the last scans, as the odometry places them.
TEST(LidarOdometry, DeSkewedPointsLieOnTheWalls) {
  for (const bool has_imu : {true, false}) {
    RoomRun run;
    run.has_imu = has_imu;
    const LidarOdometry odometry = run.odometry();
    const Pose truth_from_estimate =
        run.room.world_from_lidar(0) * odometry.world_from_camera(run.room.start_ns)->inverse();
    std::vector<double> off, raw;
    for (int scan = 30; scan < 40; ++scan)
      for (const LidarPoint& p : run.room.scan(scan)) {
        const auto now = odometry.world_from_camera(run.room.scan_start_ns(scan) + p.offset_ns);
        const auto end = odometry.world_from_camera(run.room.scan_start_ns(scan + 1));
        ASSERT_TRUE(now && end);
        off.push_back(run.room.off_surfaces_m(truth_from_estimate * (*now * Vector3d(p.x, p.y, p.z))));
        raw.push_back(run.room.off_surfaces_m(truth_from_estimate * (*end * Vector3d(p.x, p.y, p.z))));
      }
    const auto p95 = [](std::vector<double> v) {
      std::nth_element(v.begin(), v.begin() + v.size() * 95 / 100, v.end());
      return v[v.size() * 95 / 100];
    };
    EXPECT_LT(p95(off), 0.02);
    EXPECT_GT(p95(raw), 0.08);  // there was something to undo
  }
}

// A wall that goes along with the sensor fills the left of its view: without masks it would be followed.
TEST(LidarOdometry, PointsOnMaskedBodiesDoNotCount) {
  RoomRun run;
  run.room.pattern = LidarRoom::Pattern::forward;
  run.room.range_sigma_m = 0.01;
  const Camera camera;
  LidarRigView rig;
  rig.camera = camera;
  rig.imu = ImuCalibration();
  rig.camera_from_lidar.rotation = Eigen::Quaterniond(Eigen::Matrix3d{{0, -1, 0}, {0, 0, -1}, {1, 0, 0}});
  rig.imu->camera_from_imu = rig.camera_from_lidar;
  LidarOdometry odometry(rig, run.room.imu(4), run.options);
  cv::Mat masks = cv::Mat::zeros(camera.height, camera.width, CV_16UC1);
  masks.colRange(0, 250).setTo(3);
  int bodies = 0, expected = 0;
  for (int i = 0; i < 20; ++i) {
    std::vector<LidarPoint> points = run.room.scan(i);
    for (LidarPoint& p : points) {
      const auto pixel = camera.project(rig.camera_from_lidar * Vector3d(p.x, p.y, p.z));
      if (!pixel || pixel->x() >= 245 || pixel->y() < 0 || pixel->y() > camera.height - 1 || pixel->x() < 0)
        continue;
      const float scale = 2 / p.x;
      p.x *= scale, p.y *= scale, p.z *= scale;
      ++expected;
    }
    for (int k = 1; k <= 4; ++k) odometry.add_masks(run.room.scan_start_ns(i) + 25'000'000 * k, masks);
    odometry.add_scan(run.room.scan_start_ns(i), points);
    odometry.end_sweep(run.room.scan_start_ns(i + 1));
  }
  for (const SweepReport& report : odometry.reports()) bodies += report.on_bodies;
  EXPECT_GE(bodies, expected);
  EXPECT_GT(expected, 10'000);
  const auto first = odometry.world_from_camera(0), last = odometry.world_from_camera(2'000'000'000);
  ASSERT_TRUE(first && last);
  const Pose lidar_from_camera = rig.camera_from_lidar.inverse();
  const Pose truth = relative_pose(run.room.world_from_lidar(0) * lidar_from_camera,
                                   run.room.world_from_lidar(2) * lidar_from_camera);
  EXPECT_LT((relative_pose(*first, *last).translation - truth.translation).norm(), 0.05);
}

}  // namespace
}  // namespace uniquadric
