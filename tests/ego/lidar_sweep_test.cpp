// What sweeps are made of: points and their times, IMU readings, files.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "core/base/random.h"
#include "estimator/ego/lidar_ego.h"
#include "tests/ego/room_run.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {

using Eigen::Vector3d;

TEST(LidarSweep, TimesThatDoNotSpanAScanAreInAnotherUnit) {
  EXPECT_FALSE(point_times_fault(0, 10));  // of an instant
  EXPECT_FALSE(point_times_fault(99'000'000, 10));
  EXPECT_TRUE(point_times_fault(99'000, 10));
  EXPECT_EQ(point_times_fault(990'000'000, 10),
            "the points' times span 0.99 s of a scan, of 0.1 s: in another unit?");
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
    const SweepPoint point = path.place(stamp_ns, body);
    const EndPoint at_end = end_point(path.end(), path.end().gyroscope_bias_radps, point);
    EXPECT_LT((world_point(path.end(), point, at_end) - then.world_from_body * body).norm(), 1e-9);
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
  const RoomErrors errors = errors_of(run.odometry(), run);
  EXPECT_EQ(errors.missing, 0);
  EXPECT_LT(errors.max_m, 0.05);
}

// A recording of a LiDAR alone, and an IMU where there are readings, through its files.
Sequence recording(const std::filesystem::path& folder,
                   const std::vector<std::pair<std::int64_t, std::vector<LidarPoint>>>& scans,
                   const std::vector<ImuSample>& readings = {}) {
  Sequence made;
  made.name = "recording";
  made.rate_hz = 10;
  made.lidar = LidarCalibration{.pattern = "test", .rate_hz = 10, .camera_from_lidar = {}};
  if (!readings.empty()) {
    made.imu = ImuCalibration{};
    write_imu_csv(folder / "imu.csv", readings);
  }
  std::filesystem::create_directories(folder / "lidar");
  for (const auto& [start_ns, points] : scans) {
    made.scans.push_back({start_ns, "lidar/" + std::to_string(made.scans.size()) + ".pcd"});
    write_lidar_points(folder / made.scans.back().file, points);
  }
  write_sequence_index(folder, made);
  std::filesystem::remove(folder / "rgb.txt");
  return open_sequence(folder);
}

TEST(LidarEgo, FollowsASequenceWithoutImages) {
  const TempFolder temp;
  const LidarRoom room;
  std::vector<std::pair<std::int64_t, std::vector<LidarPoint>>> scans;
  for (int i = 0; i < 15; ++i) scans.emplace_back(room.scan_start_ns(i), room.scan(i));
  const Sequence sequence = recording(temp.path(), scans);
  ASSERT_TRUE(sequence.frames.empty());
  LidarEgo ego(sequence, {});
  ego.finish();
  const Trajectory trajectory = ego.trajectory();
  ASSERT_EQ(trajectory.size(), 15U);
  const Pose found = relative_pose(trajectory.front().pose, trajectory.back().pose);
  const Pose truth = relative_pose(room.world_from_lidar(0.1), room.world_from_lidar(1.5));
  EXPECT_LT((found.translation - truth.translation).norm(), 0.03);
}

// As of a recording whose scans have one stamp each, set back by a scan's time: a scan that comes early
// begins before the points of the one before it.
TEST(LidarEgo, ASweepHasTheScansOwnPointsWhereIntervalsAreUneven) {
  const TempFolder temp;
  const LidarRoom room;
  std::vector<LidarPoint> points = room.scan(0);
  for (LidarPoint& point : points) point.offset_ns = 100'000'000;
  std::vector<std::pair<std::int64_t, std::vector<LidarPoint>>> scans;
  std::vector<std::int64_t> ends_ns;
  for (int i = 0; i < 12; ++i) {
    const std::int64_t start_ns = i * 100'000'000 + (i % 3 - 1) * 2'000'000 + 2'000'000;
    scans.emplace_back(start_ns, points);
    ends_ns.push_back(start_ns + 100'000'000);
  }
  const Sequence sequence = recording(temp.path(), scans);
  LidarEgo ego(sequence, {});
  ego.finish();
  EXPECT_EQ(ego.stamps_ns(), ends_ns);
  for (const SweepReport& report : ego.odometry().reports())
    EXPECT_EQ(report.points, ego.odometry().reports().front().points);
}

// The IMU's axes are turned by a quarter about z against what the calibration says.
TEST(LidarEgo, BiasesThatNoImuHasAreTold) {
  const auto faults = [](bool is_turned) {
    const TempFolder temp;
    LidarRoom room;
    room.range_sigma_m = 0.01;
    std::vector<std::pair<std::int64_t, std::vector<LidarPoint>>> scans;
    for (int i = 0; i < 35; ++i) scans.emplace_back(room.scan_start_ns(i), room.scan(i));
    std::vector<ImuSample> samples = room.imu(4);
    for (ImuSample& sample : samples)
      for (Vector3d* v : {&sample.angular_velocity_radps, &sample.specific_force_mps2})
        if (is_turned) *v = Vector3d(-v->y(), v->x(), v->z());
    const Sequence sequence = recording(temp.path(), scans, samples);
    LidarEgo ego(sequence, {});
    ego.finish();
    return ego.scan_faults();
  };
  EXPECT_TRUE(faults(false).empty());
  const std::vector<std::string> told = faults(true);
  const auto is_told = [&](std::string_view what) {
    return std::ranges::any_of(told,
                               [&](const auto& fault) { return fault.find(what) != std::string::npos; });
  };
  EXPECT_TRUE(is_told("its units, axes, clock or the calibration may be wrong"));
  EXPECT_TRUE(is_told("hardly lie on what was seen before"));  // the map is left with so wrong a motion
}

TEST(LidarEgo, AMotionThatAsksForAnImuIsToldWithoutOne) {
  const auto is_told = [](double vigour, bool has_imu) {
    const TempFolder temp;
    LidarRoom room;
    room.range_sigma_m = 0.02;
    room.vigour = vigour;
    std::vector<std::pair<std::int64_t, std::vector<LidarPoint>>> scans;
    for (int i = 0; i < 20; ++i) scans.emplace_back(room.scan_start_ns(i), room.scan(i));
    const Sequence sequence = recording(temp.path(), scans, room.imu(2.5));
    LidarEgoOptions options;
    options.odometry.use_imu = has_imu;
    LidarEgo ego(sequence, options);
    ego.finish();
    return std::ranges::any_of(ego.scan_faults(), [](const std::string& fault) {
      return fault.find("constant within a sweep") != std::string::npos;
    });
  };
  EXPECT_FALSE(is_told(1, false));
  EXPECT_TRUE(is_told(6, false));
  EXPECT_FALSE(is_told(6, true));
}

TEST(LidarEgo, ScansWithTimesThatNoneHasAreRefusedByName) {
  const TempFolder temp;
  const Sequence sequence = recording(temp.path(), {{0, {LidarPoint{.x = 5, .offset_ns = 3'000'000'000}}}});
  LidarEgo ego(sequence, {});
  EXPECT_NE(input_error([&] { ego.finish(); }).find("0.pcd: point 0: 3 s after the scan's start"),
            std::string::npos);
}

}  // namespace
}  // namespace uniquadric
