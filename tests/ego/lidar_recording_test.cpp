// Recordings with a LiDAR, as real ones are, through estimate().
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>

#include "core/base/config.h"
#include "core/base/files.h"
#include "core/base/random.h"
#include "core/sequence/ply.h"
#include "core/sequence/tracks.h"
#include "estimator/estimate.h"
#include "estimator/perception/perception_files.h"
#include "tests/ego/room_recording.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

Variant lidar_variant() {
  Variant variant;
  variant.perception.ego = EgoSource::lidar;
  variant.perception.aot.enabled = false;
  return variant;
}

Variant lidar_only_variant() {
  return load_variant(fs::path(UNIQUADRIC_SOURCE_DIR) / "configs/variants/lidar_only.yaml");
}

// For bodies as large as a room allows.
Variant mover_variant() {
  Variant variant = lidar_only_variant();
  variant.perception.scan_objects.clusters.tolerance_m = 0.3;
  variant.perception.scan_objects.clusters.max_extent_m = 4;
  return variant;
}

Tracks estimated(const fs::path& sequence, const Variant& variant, const fs::path& out) {
  EstimateOptions options;
  options.quiet = options.force = true;
  options.threads = 1;
  estimate(sequence, variant, options, out);
  return read_tracks(out);
}

class LidarRecording : public testing::Test {
 protected:
  LidarRecording() {
    recording_.room.range_sigma_m = 0.01;
    recording_.room.points = 8000;
    recording_.room.pattern = LidarRoom::Pattern::forward;
    recording_.room.start_ns = 20'000'000'000;
  }
  Tracks estimated(const Variant& variant) {
    write_recording(temp_.path() / "sequence", recording_);
    return uniquadric::estimated(temp_.path() / "sequence", variant, temp_.path() / "out");
  }
  // A body for mover_variant() that comes towards the sensor.
  void add_mover() {
    recording_.room.mover_half_m = {0.7, 0.5, 0.6};
    recording_.room.mover_start_m = {5, -1.4, -1.88};
    recording_.room.mover_velocity_mps = {-1.5, 0.3, 0};
    recording_.room.vigour = 0.3;
  }
  // On stderr.
  std::string said_of_files(const Variant& variant = lidar_only_variant()) const {
    testing::internal::CaptureStderr();
    uniquadric::estimated(temp_.path() / "sequence", variant, temp_.path() / "out");
    return testing::internal::GetCapturedStderr();
  }
  std::string said(const Variant& variant = lidar_only_variant()) const {
    write_recording(temp_.path() / "sequence", recording_);
    return said_of_files(variant);
  }
  ConfigNode run() const { return ConfigNode::load(temp_.path() / "out/run.yaml"); }
  std::string counts() const {
    return fmt::format("{} {}, {} without pose", run().get<int>("frames"),
                       run().get<std::string>("frames_are"), run().get<int>("frames_without_pose"));
  }
  std::string written() const {
    return read_text(temp_.path() / "out/camera.tum") + read_text(temp_.path() / "out/objects.csv");
  }

  TempFolder temp_;
  RoomRecording recording_;
};

// Ego motion, depth of a body under its mask, and bodies of a LiDAR alone.
TEST_F(LidarRecording, ClocksThatAreApartAreOneByTheOptions) {
  constexpr std::int64_t kLidar_ns = 3'000'000'000, kImu_ns = -40'000'000;
  for (const bool has_images : {true, false}) {
    recording_.has_images = recording_.has_imu = has_images;
    recording_.room.mover_half_m = has_images ? Eigen::Vector3d::Zero() : Eigen::Vector3d(0.7, 0.5, 0.6);
    recording_.room.mover_start_m = {5, -1.4, -1.88};
    recording_.room.mover_velocity_mps = {-1.5, 0.3, 0};
    recording_.room.vigour = has_images ? 1 : 0.3;
    Variant variant = has_images ? lidar_variant() : lidar_only_variant();
    variant.perception.scan_objects.clusters.tolerance_m = 0.3;
    variant.perception.scan_objects.clusters.max_extent_m = 4;
    recording_.lidar_clock_ns = recording_.imu_clock_ns = 0;
    const Tracks plain = estimated(variant);
    EXPECT_FALSE(plain.objects.empty()) << has_images;
    EXPECT_GT(plain.camera.size(), 15u) << has_images;
    const std::string expected = written();
    recording_.lidar_clock_ns = kLidar_ns, recording_.imu_clock_ns = kImu_ns;
    variant.perception.lidar_time_offset_ns = kLidar_ns;
    variant.perception.lidar.imu_time_offset_ns = kImu_ns;
    estimated(variant);
    EXPECT_EQ(written(), expected) << has_images;
  }
}

// What real drivers write: empty returns, numbers that are none or that are no ranges, points in the order of
// rings, scans without a point. The same poses and bodies come out as of the clean recording.
TEST_F(LidarRecording, BadPointsOfDriversChangeNothing) {
  add_mover();
  const Tracks clean = estimated(mover_variant());
  const std::string expected = written();
  ASSERT_EQ(clean.camera.size(), 20u);
  ASSERT_FALSE(clean.objects.empty());
  recording_.change = [](int scan, std::vector<LidarPoint>& points) {
    RandomStream random(9, "dirt", static_cast<std::uint64_t>(scan));
    const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
    for (const LidarPoint& bad :
         {LidarPoint{}, LidarPoint{.x = nan}, LidarPoint{.y = inf},
          LidarPoint{.x = 3e38f, .y = 3e38f, .z = 3e38f}, LidarPoint{.x = 5000, .y = 30, .z = 2},
          LidarPoint{.x = 1200, .y = -60, .z = -20}})
      for (int i = 0; i < 300; ++i) {
        points.push_back(bad);
        points.back().offset_ns = random.below(100'000'000);
      }
    std::stable_sort(points.begin(), points.end(),
                     [](const auto& a, const auto& b) { return a.ring < b.ring; });
    for (std::size_t i = points.size(); i > 1; --i)
      std::swap(points[i - 1], points[random.below(static_cast<std::uint32_t>(i))]);
  };
  estimated(mover_variant());
  EXPECT_EQ(written(), expected);
}

TEST_F(LidarRecording, EmptyScansAreGoneThroughAndNothingButEmptyOnesHaveNoPose) {
  recording_.change = [](int scan, std::vector<LidarPoint>& points) {
    if (scan % 6 == 3) points.clear();
  };
  EXPECT_EQ(estimated(lidar_only_variant()).camera.size(), 20u);
  recording_.change = [](int, std::vector<LidarPoint>& points) {
    for (LidarPoint& p : points) p.x = p.y = p.z = 0;
  };
  EXPECT_TRUE(estimated(lidar_only_variant()).camera.empty());
}

// What is said of a recording, and counted: the scans, and those without a pose.
TEST_F(LidarRecording, ScansWithoutAPoseAreCountedAndTheReasonIsTold) {
  const std::string none = "warning: no object has a state (run.yaml counts poses)\n";
  EXPECT_EQ(said(), none);
  EXPECT_EQ(counts(), "20 scans, 0 without pose");

  recording_.change = [](int, std::vector<LidarPoint>& points) {
    for (LidarPoint& p : points) p.x = p.y = p.z = 0;
  };
  EXPECT_EQ(said(),
            "warning: 20 of 20 scans hold no point of use, the first lidar/0.pcd: none, or all are empty "
            "returns (0, 0, 0), no numbers, or not from 0.5 to 120 m away\n"
            "warning: 20 of 20 scans have no pose (run.yaml: frames_without_pose)\n"
            "warning: the LiDAR has no pose for 1.9 s (scans 0 to 19)\n" +
                none);
  EXPECT_EQ(counts(), "20 scans, 20 without pose");

  recording_.change = [](int scan, std::vector<LidarPoint>& points) {
    if (scan < 7) points.clear();
    if (scan == 4) points = {{.x = 0.2f}, {.y = 3000}, {.z = std::numeric_limits<float>::quiet_NaN()}};
  };
  const std::string text = said();
  EXPECT_EQ(text.find("warning: 7 of 20 scans hold no point of use, the first lidar/0.pcd: "), 0u) << text;
  const auto without_pose = static_cast<std::size_t>(run().get<int>("frames_without_pose"));
  EXPECT_GE(without_pose, 5u);  // the motion is trusted for 0.15 s before the first points
  EXPECT_NE(text.find(fmt::format("warning: {} of 20 scans have no pose ", without_pose)), std::string::npos);
  EXPECT_EQ(read_tracks(temp_.path() / "out").camera.size(), 20 - without_pose);
}

TEST_F(LidarRecording, PointsWithoutTimesAreToldWhereTheSensorMoves) {
  const std::string told = " of 20 scans have no times (one each scan), and the sensor moves or is lost: ";
  recording_.change = [](int, std::vector<LidarPoint>& points) {
    for (LidarPoint& p : points) p.offset_ns = 50'000'000;
    points.push_back({.offset_ns = 7});  // an empty return
  };
  recording_.room.vigour = 0.1;
  EXPECT_EQ(said().find("no times"), std::string::npos);
  recording_.room.half_size_m.x() = 30;
  recording_.room.velocity_mps = {8, 0, 0};
  const std::string text = said();
  EXPECT_NE(text.find("warning: the points of 20" + told), std::string::npos) << text;
  recording_.change = nullptr;
  EXPECT_EQ(said().find("no times"), std::string::npos);
}

TEST_F(LidarRecording, AGapInTheListOfScansIsToldWithItsTimeAndLength) {
  write_recording(temp_.path() / "sequence", recording_);
  const fs::path list = temp_.path() / "sequence/lidar.txt";
  const auto without = [&](int first, int last) {
    std::string text = read_text(list);
    const auto at = [&](int scan) { return text.find(fmt::format("{:.9f} ", 20 + 0.1 * scan)); };
    const std::size_t begin = at(first), end = at(last + 1);
    ASSERT_LT(begin, end);
    write_text(list, text.erase(begin, end - begin));
  };
  without(14, 15);  // as a driver may lose
  EXPECT_EQ(said_of_files().find("lidar.txt"), std::string::npos);
  without(4, 9);
  const std::string told =
      "warning: " + list.string() + ": no scan for 0.7 s after 20.300000000 s, where one comes every 0.1 s";
  EXPECT_EQ(said_of_files().find(told + "\n"), 0u) << said_of_files();
  without(16, 17);
  EXPECT_EQ(said_of_files().find(told + " (the longest of 2 such gaps)\n"), 0u) << said_of_files();
}

TEST_F(LidarRecording, PointsTimesInAnotherUnitAreTold) {
  recording_.room.vigour = 0.1;
  EXPECT_EQ(said().find("in another unit?"), std::string::npos);
  recording_.change = [](int, std::vector<LidarPoint>& points) {
    for (LidarPoint& p : points) p.offset_ns /= 1000;
    points.push_back({.offset_ns = 90'000'000});  // an empty return
  };
  const std::string text = said();
  EXPECT_NE(
      text.find("warning: the points' times span 0.0001 s of a scan at most, of 0.1 s: in another unit?\n"),
      std::string::npos)
      << text;
}

// In the file's own time, where the clocks are apart; not where the variant does without the IMU.
TEST_F(LidarRecording, ReadingsThatDoNotCoverTheScansAreTold) {
  recording_.has_imu = true;
  recording_.imu_clock_ns = 7'000'000'000;
  Variant variant = lidar_only_variant();
  variant.perception.lidar.imu_time_offset_ns = 7'000'000'000;
  EXPECT_EQ(said(variant).find("imu.csv"), std::string::npos);
  const fs::path file = temp_.path() / "sequence/imu.csv";
  std::vector<ImuSample> samples = read_imu_csv(file);
  std::erase_if(samples, [](const ImuSample& s) { return s.stamp_ns > 28'500'000'000; });
  write_imu_csv(file, samples);
  const std::string told =
      "warning: " + file.string() +
      ": no reading from 28.500000000 to 29.000000000 s, where one comes every 0.005 s\n";
  EXPECT_NE(said_of_files(variant).find(told), std::string::npos) << said_of_files(variant);
  variant.perception.lidar.odometry.use_imu = false;
  EXPECT_EQ(said_of_files(variant).find("imu.csv"), std::string::npos);
}

TEST_F(LidarRecording, ADriverThatFroze) {
  const auto at = [this](int scan) { return recording_.room.scan(scan); };
  for (const bool has_images : {false, true}) {
    recording_.has_images = recording_.has_imu = has_images;
    recording_.change = [&](int scan, std::vector<LidarPoint>& points) {
      if (scan >= 4 && scan <= 9) points = at(4);
      if (scan == 15) points = at(14);
      for (LidarPoint& p : points) p.intensity = static_cast<float>(scan);
    };
    const std::string told =
        "warning: scans 4 to 9 (and 1 more such runs) hold the same points, as of a driver that froze\n";
    const std::string text = said(has_images ? lidar_variant() : lidar_only_variant());
    EXPECT_NE(text.find(told), std::string::npos) << text;
  }
}

// Each is refused with the file and what is wrong with it, and nothing is left.
TEST_F(LidarRecording, FilesThatContradictThemselvesAreRefused) {
  const fs::path sequence = temp_.path() / "sequence", scan = sequence / "lidar/7.pcd",
                 list = sequence / "lidar.txt";
  recording_.scans = 12;
  const auto replaced = [](std::string text, const std::string& what, const std::string& by) {
    const std::size_t at = text.find(what);
    EXPECT_NE(at, std::string::npos) << what;
    return at == std::string::npos ? text : text.replace(at, what.size(), by);
  };
  const auto line = [](int i) { return fmt::format("{}.{}00000000 lidar/{}.pcd\n", 20 + i / 10, i % 10, i); };
  struct Case {
    fs::path file;
    std::function<std::string(std::string)> spoil;
    std::string said;
  };
  const std::vector<Case> cases = {
      {scan, [&](auto text) { return replaced(text, "POINTS 8000", "POINTS 9000"); }, "7.pcd"},
      {scan, [&](auto text) { return replaced(text, "WIDTH 8000", "WIDTH 7000"); }, "7.pcd"},
      {scan, [&](auto text) { return text.substr(0, text.size() - 5); }, "7.pcd"},
      {scan, [&](auto text) { return replaced(text, " t ", " s "); }, "7.pcd"},
      {scan, [&](auto text) { return replaced(text, "SIZE 4 4 4", "SIZE 8 4 4"); }, "7.pcd"},
      {scan, [&](auto text) { return replaced(text, "DATA binary", "DATA bin"); }, "7.pcd"},
      {scan, [](auto) { return std::string(); }, "7.pcd"},
      {list, [&](auto text) { return replaced(text, line(5) + line(6), line(6) + line(5)); }, "lidar.txt:"},
      {list, [&](auto text) { return replaced(text, line(5), line(5) + line(5)); }, "lidar.txt:"},
      {list, [&](auto text) { return replaced(text, "lidar/5.pcd", "lidar/55.pcd"); }, "55.pcd"},
  };
  int refused = 0;
  for (const Case& c : cases) {
    write_recording(sequence, recording_);
    write_text(c.file, c.spoil(read_text(c.file)));
    const fs::path out = temp_.path() / "spoilt";
    const std::string message =
        input_error([&] { uniquadric::estimated(sequence, lidar_only_variant(), out); });
    EXPECT_NE(message.find(c.said), std::string::npos) << refused << ": " << message;
    EXPECT_FALSE(fs::exists(out));
    ++refused;
  }
  EXPECT_EQ(refused, 10);
}

// Points without times (all 0) are those of a sensor at rest: nothing can be undone, and nothing fails.
TEST_F(LidarRecording, PointsWithoutTimesAreThoseOfAnInstant) {
  recording_.room.vigour = 0.2;
  recording_.change = [](int, std::vector<LidarPoint>& points) {
    for (LidarPoint& p : points) p.offset_ns = 0;
  };
  const Tracks tracks = estimated(lidar_only_variant());
  ASSERT_EQ(tracks.camera.size(), 20u);
  const Pose lidar_from_camera = Pose{camera_from_forward(), {0.1, 0.2, -0.05}}.inverse();
  const Pose truth = relative_pose(recording_.room.world_from_lidar(0.1) * lidar_from_camera,
                                   recording_.room.world_from_lidar(2) * lidar_from_camera);
  const Pose found = relative_pose(tracks.camera.front().pose, tracks.camera.back().pose);
  EXPECT_LT((found.translation - truth.translation).norm(), 0.05);
}

// Carried to the room by the first pose, its points lie on walls and cupboards; a kept perception has the
// same.
TEST_F(LidarRecording, TheMapThatIsWrittenIsOfTheRoom) {
  recording_.room.vigour = 0.3;
  const Tracks tracks = estimated(lidar_only_variant());
  const SurfaceFile map = read_surface_ply(temp_.path() / "out/map.ply");
  const Pose lidar_from_camera = Pose{camera_from_forward(), {0.1, 0.2, -0.05}}.inverse();
  const Pose room_from_world =
      recording_.room.world_from_lidar(0.1) * lidar_from_camera * tracks.camera.front().pose.inverse();
  ASSERT_GT(map.points.size(), 500u);
  std::vector<double> off_m;
  for (const Eigen::Vector3f& p : map.points)
    off_m.push_back(recording_.room.off_surfaces_m(room_from_world * p.cast<double>()));
  std::sort(off_m.begin(), off_m.end());
  EXPECT_LT(off_m[off_m.size() / 2], 0.01);       // the noise of points is 1 cm, of few of them less
  EXPECT_LT(off_m[off_m.size() * 9 / 10], 0.05);  // means of cells across an edge lie beside it
  EXPECT_LT(off_m.back(), 0.25);                  // a cell
  EstimateOptions kept;
  kept.quiet = true;
  kept.perception = temp_.path() / "kept";
  estimate(temp_.path() / "sequence", lidar_only_variant(), kept, temp_.path() / "again");
  for (const char* file : {"again/map.ply", "kept/map.ply"})
    EXPECT_TRUE(read_text(temp_.path() / file) == read_text(temp_.path() / "out/map.ply")) << file;
  EXPECT_TRUE(foreign_files(kept.perception).empty());
}

}  // namespace
}  // namespace uniquadric
