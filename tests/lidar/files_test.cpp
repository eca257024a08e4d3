#include <gtest/gtest.h>

#include <cstring>

#include "core/base/config.h"
#include "core/base/files.h"
#include "core/sequence/pcd.h"
#include "simulator/lidar/lidar_reader.h"
#include "simulator/lidar/point_truth.h"
#include "tests/lidar/lidar_support.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {

using Eigen::Vector3d;

LidarScan small_scan() {
  LidarScan scan{.start_ns = 5, .beams = 4, .points = {}, .truth = {}};
  scan.points = {{1.5f, -2, 0.25f, 75, 0, 3, 0}, {1e-3f, 1e3f, -7, 255, 99'999'999, 65'535, 48}};
  scan.truth = {{2.5f, 0.5f, 65'535, LidarPointTruth::Kind::surface},
                {1e3f, 0, 0, LidarPointTruth::Kind::false_alarm}};
  return scan;
}

TEST(Pcd, RoundTrips) {
  const TempFolder folder;
  const LidarScan scan = small_scan();
  const Pose pose{Eigen::Quaterniond(0.5, -0.5, 0.5, 0.5), {0.1, -1e6, 1.0 / 3}};
  write_lidar_points(folder.path() / "p.pcd", scan.points);
  write_point_truth(folder.path() / "t.pcd", scan.truth, pose);
  LidarScan read{.start_ns = 5,
                 .beams = 4,
                 .points = read_lidar_points(folder.path() / "p.pcd"),
                 .truth = read_point_truth(folder.path() / "t.pcd")};
  EXPECT_EQ(bytes_of(read), bytes_of(scan));
  const PcdFile truth = read_pcd(folder.path() / "t.pcd");
  EXPECT_EQ(truth.viewpoint.rotation.coeffs(), pose.rotation.coeffs());
  EXPECT_EQ(truth.viewpoint.translation, pose.translation);
}

TEST(Pcd, HeaderAndBytesAreThoseOfTheFormat) {
  const TempFolder folder;
  write_lidar_points(folder.path() / "p.pcd", small_scan().points);
  const std::string text = read_text(folder.path() / "p.pcd");
  const std::string header =
      "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z intensity offset_time t time "
      "ring tag\n"
      "SIZE 4 4 4 4 4 4 4 2 1\nTYPE F F F F U U F U U\nCOUNT 1 1 1 1 1 1 1 1 1\nWIDTH 2\nHEIGHT 1\n"
      "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA binary\n";
  ASSERT_EQ(text.substr(0, header.size()), header);
  ASSERT_EQ(text.size(), header.size() + 2 * 31);
  const char* second = text.data() + header.size() + 31;
  float seconds = 0;
  std::memcpy(&seconds, second + 24, sizeof seconds);
  EXPECT_FLOAT_EQ(seconds, 0.099999999f);
  EXPECT_EQ(static_cast<unsigned char>(second[28]), 255);
  EXPECT_EQ(second[30], 48);
}

TEST(Pcd, RefusesHeadersThatContradictTheirData) {
  const TempFolder folder;
  const auto path = folder.path() / "p.pcd";
  write_lidar_points(path, small_scan().points);
  const std::string good = read_text(path);
  const std::vector<std::array<std::string, 3>> cases = {
      {"POINTS 2", "POINTS 3", "p.pcd:10: POINTS: 3, but WIDTH 2 times HEIGHT 1 is 2"},
      {"WIDTH 2", "WIDTH x", "p.pcd:7: WIDTH: expected a count"},
      {"POINTS 2", "POINTS -2", "p.pcd:10: POINTS: expected a count"},
      {"POINTS 2", "POINTS 4000000000",
       "p.pcd:10: POINTS: 4000000000 is more than 1000000000, the most that is read"},
      {"VERSION 0.7", "VERSION 0.6", "p.pcd:2: VERSION: expected 0.7"},
      {"SIZE 4 4", "SIZE 4", "p.pcd:4: SIZE: 8 values for 9 fields"},
      {"SIZE 4 4", "SIZE 4 8", "p.pcd: 62 bytes of data, 2 points of 35 bytes are 70"},
      {"SIZE 4 4", "SIZE 4 3", "p.pcd:4: SIZE: a value of 3 bytes"},
      {"TYPE F", "TYPE D", "p.pcd:5: TYPE: 'D' is none of F, I, U"},
      {"TYPE F", "TYPE U", "p.pcd: field x is U4, expected F4"},
      {"COUNT 1", "COUNT 2", "p.pcd:6: COUNT: field x has more than one value"},
      {"VIEWPOINT 0 0 0 1", "VIEWPOINT 0 0 0 2", "p.pcd:9: VIEWPOINT: the quaternion is not of length 1"},
      {"VIEWPOINT 0 ", "VIEWPOINT ", "p.pcd:9: VIEWPOINT: expected 7 numbers"},
      {"DATA binary", "DATA ascii", "p.pcd:11: DATA: only binary data are read"},
      {"HEIGHT 1\n", "", "p.pcd: the header has no HEIGHT"},
      {"HEIGHT 1", "WIDTH 1", "p.pcd:8: WIDTH stands twice"},
      {"HEIGHT 1", "DEPTH 1", "p.pcd:8: 'DEPTH' is no entry of a PCD header"},
      {"COUNT 1", "COUNT 0", "p.pcd:6: COUNT: field x has no value"},
      {"x y z intensity", "x y z x", "p.pcd:3: FIELDS: x stands twice"},
      {"x y z intensity", "a y z intensity", "p.pcd: has no field x"}};
  for (const auto& [from, to, message] : cases) {
    std::string bad = good;
    bad.replace(bad.find(from), from.size(), to);
    write_text(path, bad);
    const std::string said = input_error([&] { read_lidar_points(path); });
    EXPECT_NE(said.find(message), std::string::npos) << "said: " << said << "\nexpected: " << message;
  }
  write_text(path, good.substr(0, good.size() - 1));
  EXPECT_NE(input_error([&] { read_pcd(path); }).find("61 bytes of data"), std::string::npos);
  write_text(path, "");
  EXPECT_NE(input_error([&] { read_pcd(path); }).find("no VERSION"), std::string::npos);
}

// PCL leaves them behind the points, up to a whole page.
TEST(Pcd, ZerosBehindThePointsArePassedOver) {
  const TempFolder folder;
  const auto path = folder.path() / "p.pcd";
  write_lidar_points(path, small_scan().points);
  const std::string good = read_text(path);
  const PcdFile plain = read_pcd(path);
  std::string padded = good;
  padded.resize(4096, '\0');
  for (const std::string& text : {good + std::string(1, '\0'), padded}) {
    write_text(path, text);
    EXPECT_EQ(read_pcd(path).data, plain.data);
  }
  for (const std::size_t at : {good.size(), std::size_t{4095}}) {
    std::string bad = padded;
    bad[at] = '\x01';
    write_text(path, bad);
    EXPECT_NE(
        input_error([&] { read_pcd(path); }).find("2 points of 31 bytes are 62: zeros alone may follow"),
        std::string::npos);
  }
}

// As PCL writes a structure whose members are aligned.
TEST(Pcd, PaddingIsPassedOver) {
  const TempFolder folder;
  const auto path = folder.path() / "p.pcd";
  PcdFile file;
  file.fields = {{"x"}, {"y"}, {"z"}, {"_", 1, 'U', 4}, {"range"}, {"_", 1, 'U', 3}};
  file.points = 2;
  for (const float first : {1.f, 2.f}) {
    for (const float value : {first, 2.f, 3.f}) file.put(value);
    for (int k = 0; k < 4; ++k) file.put(std::uint8_t{77});
    file.put(4 + first);
    for (int k = 0; k < 3; ++k) file.put(std::uint8_t{78});
  }
  write_pcd(path, file);
  const PcdFile back = read_pcd(path);
  EXPECT_EQ(back.point_size(), 23);
  EXPECT_EQ(pcd_column(path, back, "x", 'F', 4).at<float>(1), 2);
  EXPECT_EQ(pcd_column(path, back, "range", 'F', 4).at<float>(1), 6);
  const std::string good = read_text(path);
  for (const auto& [by, said] :
       {std::pair("COUNT 1 1 1 999999999", "a point has more than 65536 bytes"),
        std::pair("COUNT 1 1 1 5", "46 bytes of data, 2 points of 24 bytes are 48")}) {
    std::string bad = good;
    bad.replace(bad.find("COUNT 1 1 1 4"), 13, by);
    write_text(path, bad);
    const std::string message = input_error([&] { read_pcd(path); });
    EXPECT_NE(message.find(said), std::string::npos) << message;
  }
}

LidarRig read(const std::string& text) {
  std::vector<std::filesystem::path> files;
  return read_lidar(ConfigNode::parse(text, "scene.yaml"), files);
}

TEST(LidarReader, ReadsEveryKey) {
  const LidarRig rig = read(
      "pattern: os1_64\nrate_hz: 20\nbody_from_lidar: {position_m: [1, 2, 3], rpy_deg: [0, 0, 90]}\n"
      "method: depth_octree\noctree_resolution_m: 0.2\nisa: avx\nmotion_keys: 2\nmotion_tolerance_m: 0.001\n"
      "noise: {model: none, range_sigma_m: 0.01, divergence_deg: 0.1, angle_sigma_deg: 0.2, quantum_m: "
      "0.004,\n"
      "  min_range_m: 1, max_range_m: 50, r10_m: 30, extinction_per_m: 0.01, detection_sigma: 0.3, "
      "false_alarm: 0.5}\n"
      "beam: {vertical_deg: 0.1, horizontal_deg: 0.2, vertical_rays: 3, horizontal_rays: 2, merge_m: 1, "
      "return: last}\n"
      "reflectivity: {sign: 50, road: 0.1}\n");
  EXPECT_EQ(rig.pattern_name, "os1_64");
  EXPECT_EQ(rig.pattern.rings(), 64);
  EXPECT_NEAR(rig.pattern.beams_per_s(), 2 * 655'360, 1e-6);  // spins as fast as it scans
  EXPECT_EQ(rig.start_ns(1), 50'000'000);
  EXPECT_EQ(rig.method, LidarMethod::depth_octree);
  EXPECT_EQ(rig.octree_resolution_m, 0.2);
  EXPECT_EQ(rig.caster.isa, "avx");
  EXPECT_EQ(rig.caster.motion_keys, 2);
  EXPECT_EQ(rig.caster.motion_tolerance_m, 0.001);
  const LidarNoise& n = rig.noise;
  const std::vector<double> numbers = {
      n.range_sigma_m, n.divergence_deg, n.angle_sigma_deg,  n.quantum_m,       n.min_range_m,
      n.max_range_m,   n.r10_m,          n.extinction_per_m, n.detection_sigma, n.false_alarm};
  EXPECT_EQ(numbers, (std::vector<double>{0.01, 0.1, 0.2, 0.004, 1, 50, 30, 0.01, 0.3, 0.5}));
  EXPECT_EQ(rig.beam.rays(), 6);
  EXPECT_EQ(rig.beam.vertical_deg + rig.beam.horizontal_deg + rig.beam.merge_m, 0.1 + 0.2 + 1);
  EXPECT_EQ(rig.beam.returned, LidarBeam::Return::last);
  ASSERT_EQ(rig.reflectivity.size(), 2u);
  EXPECT_EQ(rig.reflectivity[0], (std::pair<std::string, double>("sign", 50)));
  // Left of the lidar is behind the body, that is behind the camera, whose centre is the body's.
  EXPECT_NEAR((rig.camera_from_lidar * Vector3d(0, 1, 0) - Vector3d(-2, -3, 0)).norm(), 0, 1e-12);
}

TEST(LidarReader, DefaultsAreTheSensors) {
  const LidarRig mid = read("pattern: livox_mid360\n");
  EXPECT_EQ(mid.noise.r10_m, 40);
  EXPECT_EQ(mid.noise.angle_sigma_deg, 0.15);
  EXPECT_EQ(read("pattern: vlp16\n").noise.range_sigma_m, 0.03);
  EXPECT_EQ(read("pattern: livox_avia\n").beam.rays(), 1);
  const Vector3d forward = read("pattern: livox_avia\n").camera_from_lidar * Vector3d::UnitX();
  EXPECT_NEAR((forward - Vector3d::UnitZ()).norm(), 0, 1e-12);
  const LidarRig in_camera = read("pattern: livox_avia\ncamera_from_lidar: {position_m: [0, 0, 1]}\n");
  EXPECT_NEAR((in_camera.camera_from_lidar * Vector3d::Zero() - Vector3d(0, 0, 1)).norm(), 0, 1e-12);
}

// What is simulated of the noise is another matter.
TEST(LidarReader, TheDataSheetIsTheSensors) {
  const auto numbers = [](const LidarDataSheet& s) {
    return std::vector<double>{s.range_sigma_m, s.divergence_deg, s.angle_sigma_deg};
  };
  EXPECT_EQ(numbers(read("pattern: vlp16\n").data_sheet), (std::vector<double>{0.03, 0.28, 0}));
  const LidarRig exact = read("pattern: livox_mid40\nnoise: {model: none}\n");
  EXPECT_EQ(numbers(exact.data_sheet), (std::vector<double>{0.02, 0.28, 0.1}));
  EXPECT_FALSE(exact.noise.is_random());
  const LidarRig own = read("pattern: livox_mid40\nnoise: {range_sigma_m: 0.05}\n");
  EXPECT_EQ(numbers(own.data_sheet), (std::vector<double>{0.05, 0.28, 0.1}));
}

TEST(LidarReader, BoundsEveryNumber) {
  for (const std::string key : {"rate_hz: X",
                                "spin_hz: X",
                                "time_offset_s: X",
                                "octree_resolution_m: X",
                                "motion_tolerance_m: X",
                                "mounting_error: {position_m: [X, 0, 0]}",
                                "mounting_error: {rpy_deg: [0, X, 0]}",
                                "body_from_lidar: {position_m: [X, 0, 0]}",
                                "reflectivity: {sign: X}",
                                "beam: {vertical_deg: X}",
                                "beam: {horizontal_deg: X}",
                                "beam: {merge_m: X}",
                                "noise: {range_sigma_m: X}",
                                "noise: {divergence_deg: X}",
                                "noise: {angle_sigma_deg: X}",
                                "noise: {quantum_m: X}",
                                "noise: {min_range_m: X}",
                                "noise: {max_range_m: X}",
                                "noise: {r10_m: X}",
                                "noise: {extinction_per_m: X}",
                                "noise: {detection_sigma: X}",
                                "noise: {false_alarm: X}",
                                "noise: {crosstalk: X}",
                                "noise: {weak_bias_m: X}"})
    for (const char* value : {"1e30", "-1e30", ".nan", ".inf"}) {
      std::string text = key;
      text.replace(text.find('X'), 1, value);
      const std::string said = input_error([&] { read("pattern: vlp16\n" + text + "\n"); });
      EXPECT_NE(said.find("scene.yaml:2: "), std::string::npos) << text << ": " << said;
    }
}

TEST(LidarReader, RefusesByLine) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"rate_hz: 10\n", "scene.yaml:1: give one of pattern, csv"},
      {"pattern: vlp16\ncsv: a.csv\n", "give one of pattern, csv"},
      {"rate_hz: 10\npattern: vlp17\n", "scene.yaml:2: pattern: 'vlp17' is no scan pattern"},
      {"pattern: vlp16\nrate_hz: 0\n", "scene.yaml:2: rate_hz: expected a number greater than 0"},
      {"pattern: vlp16\nrate_hz: 2000\n", "scene.yaml:2: rate_hz: expected at most 1000 Hz"},
      {"csv: missing.csv\n", "missing.csv"},
      {"csv: a.csv\nspin_hz: 5\n", "scene.yaml:2: spin_hz: belongs to a pattern that spins"},
      {"pattern: vlp16\nmethod: octree\n", "scene.yaml:2: method: 'octree' is none of: embree, depth_octree"},
      {"pattern: vlp16\nmotion_keys: 1\n", "scene.yaml:2: motion_keys: expected 0"},
      {"pattern: vlp16\nmotion_keys: 130\n", "scene.yaml:2: motion_keys: expected 0 to 129"},
      {"pattern: vlp16\nnoise:\n  range_sigma_m: -1\n",
       "scene.yaml:3: noise.range_sigma_m: cannot be negative"},
      {"pattern: vlp16\nnoise:\n  false_alarm: 1\n",
       "scene.yaml:3: noise.false_alarm: expected a probability below 1"},
      {"pattern: vlp16\nnoise: {min_range_m: 9, max_range_m: 8}\n",
       "max_range_m 8 is not above min_range_m 9"},
      {"pattern: vlp16\nbeam: {vertical_rays: 17}\n", "beam.vertical_rays: expected 1 to 16, found 17"},
      {"pattern: vlp16\nbeam: {return: second}\n", "'second' is none of: first, strongest, last"},
      {"pattern: vlp16\nreflectivity: {a: -1}\n", "reflectivity.a: expected at least 0"},
      {"pattern: vlp16\nbody_from_lidar: {position_m: [0, 0]}\n", "scene.yaml:2: body_from_lidar.position_m"},
      {"pattern: vlp16\nranges: 4\n", "scene.yaml:2: unknown key 'ranges'"}};
  for (const auto& [text, message] : cases) {
    const std::string said = input_error([&] { read(text); });
    EXPECT_NE(said.find(message), std::string::npos) << "said: " << said << "\nexpected: " << message;
  }
  EXPECT_NE(input_error([] { RayCaster({}, {}, {.isa = "mmx"}); }).find("instruction set"),
            std::string::npos);
}

}  // namespace
}  // namespace uniquadric
