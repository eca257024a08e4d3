#include "estimator/ego/lidar_odometry.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>

#include "core/base/random.h"
#include "estimator/ego/lidar_ego.h"
#include "estimator/ego/lidar_observability.h"
#include "tests/ego/lidar_room.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {

using Eigen::Vector3d;

struct Errors {
  double max_m = 0, max_rad = 0;
  int missing = 0, poses = 0;
};

struct RoomRun {
  LidarRoom room;
  LidarDataSheet noise;
  LidarOdometryOptions options;
  bool has_imu = true;
  int scans = 40;
  std::function<bool(int scan)> is_dropped = [](int) { return false; };
  std::function<void(int scan, std::vector<LidarPoint>&)> change = [](int, auto&) {};

  LidarOdometry odometry() const {
    LidarRigView rig;
    rig.noise = noise;
    std::vector<ImuSample> samples;
    if (has_imu) {
      rig.imu = ImuCalibration();
      samples = room.imu(scans / room.rate_hz);
    }
    LidarOdometry odometry(rig, samples, options);
    for (int i = 0; i < scans; ++i) {
      std::vector<LidarPoint> points = room.scan(i);
      change(i, points);
      if (!is_dropped(i)) odometry.add_scan(room.scan_start_ns(i), points);
      odometry.end_sweep(room.scan_start_ns(i + 1));
    }
    odometry.finish();
    return odometry;
  }
};

// Of the poses at and between the scans' ends, after the first ones have been made to coincide.
Errors errors_of(const LidarOdometry& odometry, const RoomRun& run) {
  Errors errors;
  std::optional<Pose> truth_from_estimate;
  for (int i = 0; i <= 3 * run.scans; ++i) {
    const double t = i / (3 * run.room.rate_hz);
    const auto pose = odometry.world_from_camera(run.room.start_ns + std::llround(1e9 * t));
    errors.missing += !pose;
    if (!pose) continue;
    ++errors.poses;
    const Pose truth = run.room.world_from_lidar(t);
    if (!truth_from_estimate) truth_from_estimate = truth * pose->inverse();
    const Pose aligned = *truth_from_estimate * *pose;
    errors.max_m = std::max(errors.max_m, (aligned.translation - truth.translation).norm());
    errors.max_rad = std::max(errors.max_rad, log_so3(aligned.rotation.conjugate() * truth.rotation).norm());
  }
  return errors;
}

TEST(LidarOdometry, FollowsASpinningLidarThroughARoom) {
  RoomRun run;
  run.room.range_sigma_m = 0.02;
  const Errors errors = errors_of(run.odometry(), run);
  EXPECT_EQ(errors.missing, 0);
  EXPECT_LT(errors.max_m, 0.02);
  EXPECT_LT(errors.max_rad, 0.004);
}

TEST(LidarOdometry, FollowsItAtConstantVelocity) {
  RoomRun run;
  run.has_imu = false;
  run.room.range_sigma_m = 0.02;
  const Errors errors = errors_of(run.odometry(), run);
  EXPECT_EQ(errors.missing, 0);
  EXPECT_LT(errors.max_m, 0.03);
  EXPECT_LT(errors.max_rad, 0.01);
}

TEST(LidarOdometry, FollowsANarrowRosette) {
  RoomRun run;
  run.room.pattern = LidarRoom::Pattern::forward;
  run.room.range_sigma_m = 0.02;
  run.room.points = 10'000;
  const Errors errors = errors_of(run.odometry(), run);
  EXPECT_EQ(errors.missing, 0);
  EXPECT_LT(errors.max_m, 0.05);
  EXPECT_LT(errors.max_rad, 0.01);
}

// Walls 12 m away and more, on which two rings lie 0.4 m and more apart: the points of one are a line, and
// noise makes a plane of it that goes along with the sensor.
TEST(LidarOdometry, FollowsSixteenRingsThroughAHall) {
  for (const bool has_imu : {true, false}) {
    RoomRun run;
    run.has_imu = has_imu;
    run.room.pattern = LidarRoom::Pattern::rings;
    run.room.half_size_m = {20, 12, 3};
    run.room.velocity_mps = {1.2, 0, 0};
    run.room.vigour = 0.3;
    run.room.range_sigma_m = 0.03;
    run.room.points = 20'000;
    run.noise = {.range_sigma_m = 0.03, .divergence_deg = 0.28, .angle_sigma_deg = 0};
    const Errors errors = errors_of(run.odometry(), run);
    EXPECT_EQ(errors.missing, 0);
    EXPECT_LT(errors.max_m, 0.01 * 1.2 * 4);
    EXPECT_LT(errors.max_rad, 0.01);
  }
}

TEST(LidarOdometry, FindsTheBiasesOfItsImu) {
  RoomRun run;
  run.room.gyroscope_bias_radps = {0.01, -0.02, 0.015};
  run.room.accelerometer_bias_mps2 = {0.05, 0.03, -0.04};
  run.room.range_sigma_m = 0.01;
  const Errors errors = errors_of(run.odometry(), run);
  EXPECT_LT(errors.max_m, 0.02);
  EXPECT_LT(errors.max_rad, 0.005);
}

TEST(LidarOdometry, TheImuCarriesItThroughASecondWithoutScans) {
  RoomRun run;
  run.room.range_sigma_m = 0.02;
  run.is_dropped = [](int scan) { return scan >= 20 && scan < 30; };
  const Errors errors = errors_of(run.odometry(), run);
  EXPECT_EQ(errors.missing, 0);
  EXPECT_LT(errors.max_m, 0.08);
  EXPECT_LT(errors.max_rad, 0.006);
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
  const Errors errors = errors_of(run.odometry(), run);
  EXPECT_EQ(errors.missing, 0);
  EXPECT_LT(errors.max_m, 0.15);
  run.options.sight.range_sigma_m = 0.02;  // the variant overrides the sensor
  EXPECT_LT(on_planes(), 1.5 * unknown);
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

TEST(LidarFilter, GravityIsAsStrongAsItIsKnownToBe) {
  LidarBelief belief;
  belief.state.gravity_mps2 = {1, 0, -9.81};
  belief.covariance.block<3, 3>(kGravity, kGravity).diagonal() << 0.25, 0.25, 1;
  const LidarBelief found = with_gravity(belief, 9.81, 0.001);
  EXPECT_NEAR(found.state.gravity_mps2.norm(), 9.81, 1e-3);
  const Vector3d g = belief.state.gravity_mps2.normalized();
  EXPECT_NEAR(g.dot(found.covariance.block<3, 3>(kGravity, kGravity) * g), 1e-6, 1e-8);  // along it known
  EXPECT_NEAR(found.covariance(kGravity + 1, kGravity + 1), 0.25, 1e-12);  // across it as before
  belief.state.gravity_mps2.setZero();
  EXPECT_EQ(with_gravity(belief, 9.81, 0.001).covariance, belief.covariance);
}

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

// A tunnel and a floor under a ceiling, without an end: noise of planes' normals must not feign to tell what
// nothing tells. In what is told it stays exact.
TEST(LidarOdometry, WhatNothingTellsIsUncertainAndThenLost) {
  int lost = 0;
  for (const bool is_tunnel : {true, false})
    for (const bool has_imu : {true, false}) {
      RoomRun run;
      run.scans = 50;
      run.has_imu = has_imu;
      run.room.pattern = is_tunnel ? LidarRoom::Pattern::forward : LidarRoom::Pattern::spinning;
      run.room.range_sigma_m = 0.02;
      run.room.vigour = 0.3;
      run.room.is_bare = true;
      run.room.half_size_m = {500, is_tunnel ? 2.5 : 500, 2};
      run.room.max_range_m = 60;
      run.room.velocity_mps = {2, 0, 0};
      const LidarOdometry odometry = run.odometry();
      const auto first = odometry.world_from_camera(0);
      ASSERT_TRUE(first);
      for (const SweepReport& report : odometry.reports()) {
        const auto pose = odometry.world_from_camera(report.end_ns);
        lost += !pose;
        if (!pose) continue;
        const Pose truth = run.room.world_from_lidar(1e-9 * static_cast<double>(report.end_ns));
        const Vector3d off =
            (run.room.world_from_lidar(0) * first->inverse() * *pose).translation - truth.translation;
        const Vector3d sigma_m = report.place_covariance_m2.diagonal().cwiseSqrt();
        const int told = is_tunnel ? 1 : 2;
        for (int axis = 0; axis < told; ++axis)
          EXPECT_LT(std::abs(off[axis]), 5 * sigma_m[axis] + 0.2) << is_tunnel << has_imu << report.end_ns;
        for (int axis = told; axis < 3; ++axis) EXPECT_LT(std::abs(off[axis]), 0.03);
      }
      EXPECT_FALSE(odometry.world_from_camera(run.room.scan_start_ns(run.scans))) << is_tunnel << has_imu;
    }
  EXPECT_GT(lost, 60);
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

// Livox drivers give (0, 0, 0) for beams without return; others give NaN, or points in the order of rings.
TEST(LidarOdometry, BadPointsAndDisorderChangeNothing) {
  RoomRun clean, dirty;
  clean.scans = dirty.scans = 15;
  dirty.change = [](int scan, std::vector<LidarPoint>& points) {
    RandomStream random(9, "dirt", static_cast<std::uint64_t>(scan));
    for (std::size_t i = points.size(); i > 1; --i)
      std::swap(points[i - 1], points[random.below(static_cast<std::uint32_t>(i))]);
    const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
    for (const LidarPoint& bad : {LidarPoint{}, LidarPoint{.x = nan}, LidarPoint{.y = inf},
                                  LidarPoint{.x = 1e30f, .y = 1e30f}, LidarPoint{.z = -1e4f}})
      for (int i = 0; i < 500; ++i) {
        points.push_back(bad);
        points.back().offset_ns = random.below(100'000'000);
      }
  };
  const LidarOdometry a = clean.odometry(), b = dirty.odometry();
  const auto p = a.world_from_camera(1'400'000'000), q = b.world_from_camera(1'400'000'000);
  ASSERT_TRUE(p && q);
  EXPECT_EQ(p->translation, q->translation);
  EXPECT_EQ(p->rotation.coeffs(), q->rotation.coeffs());
}

TEST(LidarOdometry, EmptyScansAreGoneThrough) {
  RoomRun run;
  run.scans = 25;
  run.change = [](int scan, std::vector<LidarPoint>& points) {
    if (scan % 5 == 2) points.clear();
  };
  const Errors errors = errors_of(run.odometry(), run);
  EXPECT_EQ(errors.missing, 0);
  EXPECT_LT(errors.max_m, 0.05);
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

TEST(LidarOdometry, IsLostWhenNothingIsSeenForLong) {
  RoomRun run;
  run.has_imu = false;
  run.is_dropped = [](int scan) { return scan >= 15; };
  const LidarOdometry odometry = run.odometry();
  EXPECT_TRUE(odometry.world_from_camera(1'000'000'000));
  EXPECT_FALSE(odometry.world_from_camera(3'900'000'000));
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

// A recording of a LiDAR alone, through its files.
TEST(LidarEgo, FollowsASequenceWithoutImages) {
  const TempFolder temp;
  const LidarRoom room;
  Sequence made;
  made.name = "room";
  made.rate_hz = 10;
  made.lidar = LidarCalibration{.pattern = "test", .rate_hz = room.rate_hz, .camera_from_lidar = {}};
  std::filesystem::create_directories(temp.path() / "lidar");
  for (int i = 0; i < 15; ++i) {
    made.scans.push_back({room.scan_start_ns(i), "lidar/" + std::to_string(i) + ".pcd"});
    write_lidar_points(temp.path() / made.scans.back().file, room.scan(i));
  }
  write_sequence_index(temp.path(), made);
  std::filesystem::remove(temp.path() / "rgb.txt");
  const Sequence sequence = open_sequence(temp.path());
  ASSERT_TRUE(sequence.frames.empty());
  LidarEgo ego(sequence, {});
  ego.finish();
  const Trajectory trajectory = ego.trajectory();
  ASSERT_EQ(trajectory.size(), 15U);
  const Pose found = relative_pose(trajectory.front().pose, trajectory.back().pose);
  const Pose truth = relative_pose(room.world_from_lidar(0.1), room.world_from_lidar(1.5));
  EXPECT_LT((found.translation - truth.translation).norm(), 0.03);
}

TEST(LidarEgo, ScansWithTimesThatNoneHasAreRefusedByName) {
  const TempFolder temp;
  Sequence made;
  made.name = "broken";
  made.rate_hz = 10;
  made.lidar = LidarCalibration{.pattern = "test", .rate_hz = 10, .camera_from_lidar = {}};
  made.scans.push_back({0, "0.pcd"});
  write_lidar_points(temp.path() / "0.pcd", {LidarPoint{.x = 5, .offset_ns = 3'000'000'000}});
  write_sequence_index(temp.path(), made);
  const Sequence sequence = open_sequence(temp.path());
  LidarEgo ego(sequence, {});
  EXPECT_NE(input_error([&] { ego.finish(); }).find("0.pcd: point 0: 3 s after the scan's start"),
            std::string::npos);
}

TEST(LidarSweep, RefusesTimesThatNoScanHas) {
  LidarPoint point{.x = 5, .offset_ns = 3'000'000'000};
  EXPECT_THROW(clean_points(0, {point}, {}), std::invalid_argument);
}

TEST(LidarSweep, PlacesPointsByTheMotionOfTheSweep) {
  LidarState start;
  start.velocity_mps = {3, 0, 0};
  start.gyroscope_bias_radps = {0, 0, 0.1};
  const InertialReading reading{{0, 0, 0.6}, {0, 2, 0}};
  std::vector<ReadingPiece> pieces;
  for (int i = 1; i <= 20; ++i) pieces.push_back({i * 5'000'000, reading});
  const SweepPath path(start, pieces);
  for (const std::int64_t stamp_ns : {0, 32'000'000, 100'000'000}) {
    LidarState then = start;
    for (const ReadingPiece& piece : pieces)
      if (then.stamp_ns < stamp_ns) then = propagated(then, piece.reading, std::min(piece.end_ns, stamp_ns));
    const Vector3d body(4, -2, 1);
    EXPECT_LT((world_point(path.end(), path.end().gyroscope_bias_radps, path.place(stamp_ns, body)) -
               then.world_from_body * body)
                  .norm(),
              1e-9);
  }
}

TEST(LidarSweep, ReadingsAreThoseBetweenTheSamples) {
  std::vector<ImuSample> samples;
  for (int i = 0; i <= 10; ++i) samples.push_back({i * 10'000'000, Vector3d(i, 0, 0), Vector3d(0, 2 * i, 0)});
  const auto pieces = readings_between(samples, 14'000'000, 42'000'000);
  ASSERT_EQ(pieces.size(), 4U);
  const std::vector<std::int64_t> ends = {20'000'000, 30'000'000, 40'000'000, 42'000'000};
  const std::vector<double> values = {1.7, 2.5, 3.5, 4.1};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(pieces[i].end_ns, ends[i]);
    EXPECT_NEAR(pieces[i].reading.angular_velocity_radps.x(), values[i], 1e-12);
    EXPECT_NEAR(pieces[i].reading.specific_force_mps2.y(), 2 * values[i], 1e-12);
  }
  EXPECT_EQ(readings_between(samples, 95'000'000, 300'000'000).back().end_ns, 300'000'000);
}

}  // namespace
}  // namespace uniquadric
