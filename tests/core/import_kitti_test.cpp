#include "core/import/kitti.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
#include <numbers>
#include <opencv2/core.hpp>
#include <regex>

#include "core/base/files.h"
#include "core/sequence/pcd.h"
#include "core/sequence/sequence.h"
#include "core/sequence/tracks.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;
using Eigen::Matrix4d;
using Eigen::Vector3d;

constexpr double kRounding = 1e-9;  // m: of numbers written with 12 digits, over some metres
constexpr int kFrames = 4;
constexpr double kEarthM = 6378137;

Matrix4d rigid(const Vector3d& axis, double angle, const Vector3d& translation) {
  Matrix4d T = Matrix4d::Identity();
  T.topLeftCorner<3, 3>() = Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
  T.topRightCorner<3, 1>() = translation;
  return T;
}

std::string row(const Eigen::MatrixXd& m) {
  std::string text;
  for (int i = 0; i < m.rows(); ++i)
    for (int j = 0; j < m.cols(); ++j) text += fmt::format(" {:.12f}", m(i, j));
  return text;
}

// A recording as the benchmark's pages describe it, written with 4x4 matrices and no word of the program: a
// car (track 0) ahead of a camera that goes forward by 1 m a frame and turns.
struct KittiFolder {
  Matrix4d K = Matrix4d::Identity(), camera_from_rectified = Matrix4d::Identity(),
           R_rect = rigid({1, 2, 3}, 0.02, Vector3d::Zero()), Tr_velo, Tr_imu;
  fs::path folder;

  explicit KittiFolder(const fs::path& at) : folder(at) {
    K(0, 0) = 10, K(0, 2) = 3.5, K(1, 1) = 11, K(1, 2) = 2.5;
    camera_from_rectified(0, 3) = 0.06;
    Matrix4d axes = Matrix4d::Identity();
    axes.topLeftCorner<3, 3>() << 0, -1, 0, 0, 0, -1, 1, 0, 0;
    Tr_velo = rigid({3, -1, 2}, 0.01, {0.02, -0.07, -0.3}) * axes;
    Tr_imu = rigid({0, 0, 1}, 0.01, {-0.8, 0.3, -0.8});
    for (const char* name : {"image_02/0007", "velodyne/0007", "calib", "poses", "label_02"})
      fs::create_directories(folder / name);
    const Matrix4d P2 = K * camera_from_rectified;
    write_text(folder / "calib/0007.txt", "P0: 1 0 0 0 0 1 0 0 0 0 1 0\nP2:" + row(P2.topRows<3>()) +
                                              "\nR_rect" + row(R_rect.topLeftCorner<3, 3>()) +
                                              "\nTr_velo_cam" + row(Tr_velo.topRows<3>()) + "\nTr_imu_velo" +
                                              row(Tr_imu.topRows<3>()) + "\n");
    std::string poses, labels = "0 -1 DontCare -1 -1 -10 1 2 3 4 -1 -1 -1 -1000 -1000 -1000 -10\n";
    for (int i = 0; i < kFrames; ++i) {
      poses += row(first_from_rectified(i).topRows<3>()) + "\n";
      const Vector3d bottom = bottom_in_rectified(i);
      labels += fmt::format("{} 0 Car 0 0 0 1 2 3 4 1.5 1.6 4.2{} 0.3\n", i, row(bottom.transpose()));
      if (i == 2) labels += "2 3 Tram 0 0 0 1 2 3 4 3 2 20 1 2 30 0\n";
      write_png(file("image_02", i, "png"), cv::Mat(6, 8, CV_8UC3, cv::Scalar(1, 2, i)));
      const Eigen::Vector4d center =
          (R_rect * Tr_velo).inverse() * (bottom - Vector3d(0, 0.75, 0)).homogeneous();
      write_scan(i, {static_cast<float>(center.x()), static_cast<float>(center.y()),
                     static_cast<float>(center.z()), 0.5f, NAN, 1, 2, 0});
    }
    write_text(folder / "poses/0007.txt", poses);
    write_text(folder / "label_02/0007.txt", labels);
  }

  Matrix4d first_from_rectified(int frame) const {
    return rigid({0, 1, 0}, 0.1 * frame, {0, 0, 1.0 * frame});
  }
  Vector3d bottom_in_rectified(int frame) const { return {1.0 - frame, 1.6, 12.0 + frame}; }
  fs::path file(const char* kind, int frame, const char* extension) const {
    return folder / kind / "0007" / fmt::format("{:06}.{}", frame, extension);
  }
  void write_scan(int frame, const std::vector<float>& values) const {
    std::ofstream(file("velodyne", frame, "bin"), std::ios::binary)
        .write(reinterpret_cast<const char*>(values.data()),
               static_cast<std::streamsize>(values.size() * sizeof(float)));
  }
};

// What was said since it is captured, but that track 0, which the recording has, has another id here.
std::string captured_beside_track_0() {
  return std::regex_replace(testing::internal::GetCapturedStderr(),
                            std::regex("[^\n]*track 0 is object 4 here[^\n]*\n"), "");
}

class ImportKitti : public testing::Test {
 protected:
  ImportKitti() : source_(temp_.path() / "recording") {}
  void import() const {
    ImportKittiOptions options;
    options.quiet = options.force = true;
    import_kitti_tracking(source_.folder, options, out());
  }
  fs::path out() const { return temp_.path() / "out"; }
  // Edits a file and expects the message, and nothing written.
  void expect_refused(const fs::path& file, const std::string& find, const std::string& by,
                      const std::string& what) {
    const std::string before = read_text(source_.folder / file);
    std::string text = before;
    ASSERT_NE(text.find(find), std::string::npos) << find;
    text.replace(text.find(find), find.size(), by);
    write_text(source_.folder / file, text);
    const std::string message = input_error([&] { import(); });
    EXPECT_NE(message.find((source_.folder / file).string() + what), std::string::npos) << message;
    EXPECT_FALSE(fs::exists(out()));
    write_text(source_.folder / file, before);
  }

  TempFolder temp_;
  KittiFolder source_;
};

TEST_F(ImportKitti, SensorsReadBackAsTheRecordingHasThem) {
  import();
  const Sequence sequence = open_sequence(out());
  EXPECT_EQ(sequence.name, "recording_0007");
  EXPECT_EQ(sequence.camera.width, 8);
  EXPECT_EQ(sequence.camera.fy, 11);
  ASSERT_EQ(sequence.frames.size(), std::size_t{kFrames});
  EXPECT_EQ(sequence.frames[3].stamp_ns, 300'000'000);
  EXPECT_EQ(read_text(out() / "sequence" / sequence.frames[3].rgb),
            read_text(source_.file("image_02", 3, "png")));
  const Matrix4d expected = source_.camera_from_rectified * source_.R_rect * source_.Tr_velo;
  EXPECT_LT((sequence.lidar->camera_from_lidar.matrix() - expected).cwiseAbs().maxCoeff(), kRounding);
  ASSERT_EQ(sequence.scans.size(), std::size_t{kFrames});
  const auto points = read_lidar_points(out() / "sequence" / sequence.scans[1].file);
  ASSERT_EQ(points.size(), 2u);
  EXPECT_EQ(points[0].intensity, 127.5f);
  EXPECT_EQ(sequence.scans[1].stamp_ns + points[0].offset_ns, sequence.frames[1].stamp_ns);
  EXPECT_TRUE(std::isnan(points[1].x));  // the readers of scans pass it over, not the import
}

TEST_F(ImportKitti, SaysWhatFramesHaveNoFile) {
  const auto said = [&] {
    testing::internal::CaptureStderr();
    import();
    return captured_beside_track_0();
  };
  const auto line = [&](const char* folder, const std::string& what) {
    return "uniquadric: " + (source_.folder / folder / "0007").string() + ": " + what + "\n";
  };
  EXPECT_EQ(said(), "");
  fs::remove(source_.file("velodyne", 1, "bin"));
  const std::string scans = line("velodyne", "1 of the frames 0 to 3 have no scan, the first 000001");
  EXPECT_EQ(said(), scans);
  for (const int frame : {1, 2}) fs::remove(source_.file("image_02", frame, "png"));
  EXPECT_EQ(said(), line("image_02", "2 of the frames 0 to 3 have no image, the first 000001") + scans);
}

TEST_F(ImportKitti, TruthAndScansMeetInTheWorld) {
  import();
  const Sequence sequence = open_sequence(out());
  const Tracks truth = read_tracks(out() / "truth");
  ASSERT_EQ(truth.objects.size(), 2u);
  EXPECT_EQ(truth.objects[0].id, 3);
  EXPECT_EQ(truth.objects[1].id, 4);  // track 0, behind all others
  EXPECT_EQ(truth.objects[1].name, "car_4");
  ASSERT_EQ(truth.objects[1].states.size(), std::size_t{kFrames});
  ASSERT_EQ(truth.objects[0].states.size(), 1u);
  EXPECT_EQ(truth.objects[0].states[0].stamp_ns, 200'000'000);
  for (int i = 0; i < kFrames; ++i) {
    const Ellipsoid& car = truth.objects[1].states[i].ellipsoid;
    EXPECT_LT((car.semi_axes_m - Vector3d(2.1, 0.8, 0.75)).norm(), 1e-12);
    const auto points = read_lidar_points(out() / "sequence" / sequence.scans[i].file);
    const Vector3d center(points[0].x, points[0].y, points[0].z);
    constexpr double kSingle = 4e-6;  // m: of a float at 15 m
    EXPECT_LT((truth.camera[i].pose * (sequence.lidar->camera_from_lidar * center) -
               car.world_from_object.translation)
                  .norm(),
              kSingle);
    // the devkit: at rotation_y the length points along (cos, 0, -sin) of the camera, the height up
    const Matrix4d first = source_.first_from_rectified(i);
    const auto in_world = [&](const Vector3d& v) {
      const Vector3d c = first.topLeftCorner<3, 3>() * v;
      return Vector3d(c.z(), -c.x(), -c.y());
    };
    const Eigen::Matrix3d R = car.world_from_object.rotation.toRotationMatrix();
    EXPECT_LT((R.col(0) - in_world({std::cos(0.3), 0, -std::sin(0.3)})).norm(), kRounding);
    EXPECT_LT((R.col(2) - in_world({0, -1, 0})).norm(), kRounding);
  }
}

TEST_F(ImportKitti, OxtsPlaceTheCameraInEastNorthUp) {
  fs::remove(source_.folder / "poses/0007.txt");
  fs::create_directories(source_.folder / "oxts");
  const double latitude = 49, yaw = 0.4;
  const Vector3d step(3, 4, 0.5);  // m a frame
  std::string text;
  for (int i = 0; i < kFrames; ++i) {
    const double east_deg =
        i * step.x() / (kEarthM * std::cos(latitude * std::numbers::pi / 180)) * 180 / std::numbers::pi;
    text += fmt::format("{:.12f} {:.12f} {:.12f} 0 0 {}",
                        latitude + i * step.y() / kEarthM * 180 / std::numbers::pi, 8.4 + east_deg,
                        112 + i * step.z(), yaw);
    for (int j = 6; j < 30; ++j) text += " 0";
    text += "\n";
  }
  write_text(source_.folder / "oxts/0007.txt", text);
  import();
  const auto poses = open_sequence(out()).given_camera;
  ASSERT_TRUE(poses);
  const Matrix4d imu_from_camera =
      (source_.camera_from_rectified * source_.R_rect * source_.Tr_velo * source_.Tr_imu).inverse();
  for (int i = 0; i < kFrames; ++i) {
    const Matrix4d expected = rigid({0, 0, 1}, yaw, i * step) * imu_from_camera;
    constexpr double kSphere = 1e-4;  // m: Mercator's scale changes on the way
    EXPECT_LT(((*poses)[i].pose.matrix() - expected).cwiseAbs().maxCoeff(), kSphere);
  }
}

TEST_F(ImportKitti, ScansAloneNeedNothingElse) {
  for (const char* name : {"image_02", "calib", "poses", "label_02"}) fs::remove_all(source_.folder / name);
  import();
  const Sequence sequence = open_sequence(out());
  EXPECT_TRUE(sequence.frames.empty());
  EXPECT_EQ(sequence.scans.size(), std::size_t{kFrames});
  EXPECT_FALSE(sequence.given_camera);
  EXPECT_FALSE(fs::exists(out() / "truth"));
}

TEST_F(ImportKitti, PosesAloneAreATruthWithoutObjects) {
  fs::remove_all(source_.folder / "label_02");
  import();
  const Tracks truth = read_tracks(out() / "truth");
  EXPECT_TRUE(truth.objects.empty());
  EXPECT_TRUE(truth.calibration);
  const auto given = open_sequence(out() / "sequence").given_camera;
  ASSERT_TRUE(given);
  ASSERT_EQ(truth.camera.size(), std::size_t{kFrames});
  for (int i = 0; i < kFrames; ++i) {
    EXPECT_EQ(truth.camera[i].stamp_ns, (*given)[i].stamp_ns);
    EXPECT_EQ(truth.camera[i].pose.matrix(), (*given)[i].pose.matrix());
  }
}

TEST_F(ImportKitti, ScansThatServeSeveralImagesCountOnce) {
  for (const int frame : {1, 2}) source_.write_scan(frame, {5, 6, 7, 0});
  source_.write_scan(0, {5, 6, 7, 0});
  import();
  const Sequence sequence = open_sequence(out());
  ASSERT_EQ(sequence.scans.size(), 2u);
  EXPECT_EQ(sequence.scans[0].file, "lidar/000001.pcd");
}

TEST_F(ImportKitti, PcdScansKeepTheirTimes) {
  fs::remove(source_.file("velodyne", 1, "bin"));
  write_lidar_points(source_.file("velodyne", 1, "pcd"), {{1, 2, 3, 40, 12'345'678, 5, 16}});
  import();
  const auto points = read_lidar_points(out() / "sequence/lidar/000001.pcd");
  ASSERT_EQ(points.size(), 1u);
  EXPECT_EQ(points[0].offset_ns, 12'345'678u);
  EXPECT_EQ(points[0].intensity, 40);
  EXPECT_EQ(points[0].ring, 5);
}

// x y z of a return, then what `put` adds.
void write_pcd_scan(const fs::path& path, const std::vector<PcdField>& more,
                    const std::function<void(PcdFile&, int)>& put) {
  PcdFile file;
  file.fields = {{"x"}, {"y"}, {"z"}};
  file.fields.insert(file.fields.end(), more.begin(), more.end());
  file.points = 3;
  for (int i = 0; i < 3; ++i) {
    for (const float value : {1.f, 2.f, 3.f + static_cast<float>(i)}) file.put(value);
    put(file, i);
  }
  write_pcd(path, file);
}

TEST_F(ImportKitti, PcdTimesInSecondsAreTakenAndOthersTold) {
  fs::remove(source_.file("velodyne", 1, "bin"));
  const fs::path path = source_.file("velodyne", 1, "pcd");
  const auto times_of = [&](const PcdField& field, const std::function<void(PcdFile&, int)>& put) {
    write_pcd_scan(path, {field}, put);
    testing::internal::CaptureStderr();
    fs::remove_all(out());
    import();
    EXPECT_EQ(captured_beside_track_0(), "") << field.name << field.type << field.size;
    std::vector<double> times_ms;
    for (const LidarPoint& p : read_lidar_points(out() / "sequence/lidar/000001.pcd"))
      times_ms.push_back(p.offset_ns * 1e-6);
    return times_ms;
  };
  const auto expect_near = [](const std::vector<double>& times_ms, double tolerance_ms) {
    ASSERT_EQ(times_ms.size(), 3u);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(times_ms[static_cast<std::size_t>(i)], 20 * i, tolerance_ms);
  };
  constexpr double kFloat_ms = 1e-5, kEpoch_ms = 5e-4;  // of single precision at 0.04 s, of double at 1.6e9 s
  for (const char* name : {"t", "offset_time", "time", "timestamp"}) {
    expect_near(times_of({name, 4, 'F'}, [](PcdFile& f, int i) { f.put(0.02f * static_cast<float>(i)); }),
                kFloat_ms);
    expect_near(times_of({name, 8, 'F'}, [](PcdFile& f, int i) { f.put(0.02 * i); }), 1e-6);
  }
  for (const char* name : {"t", "offset_time"})
    expect_near(times_of({name, 4, 'U'},
                         [](PcdFile& f, int i) { f.put(static_cast<std::uint32_t>(20'000'000 * i)); }),
                1e-6);
  expect_near(times_of({"timestamp", 8, 'F'}, [](PcdFile& f, int i) { f.put(1.6e9 + 0.02 * i); }), kEpoch_ms);

  write_pcd_scan(path, {{"timestamp", 8, 'U'}, {"snr", 4, 'F'}}, [](PcdFile& f, int) {
    f.put(std::uint64_t{1'600'000'000});
    f.put(1.f);
  });
  testing::internal::CaptureStderr();
  fs::remove_all(out());
  import();
  EXPECT_EQ(captured_beside_track_0(), "uniquadric: " + path.string() +
                                           ": field snr (F4) is not taken\nuniquadric: " + path.string() +
                                           ": field timestamp (U8) is not taken\n");
  fs::remove_all(out());
  write_pcd_scan(path, {{"time", 8, 'F'}}, [](PcdFile& f, int i) { f.put(1.6e9 + 0.02 * i); });
  EXPECT_NE(input_error([&] { import(); }).find("000001.pcd: point 0: time 1600000000 is not within a scan"),
            std::string::npos);
}

TEST_F(ImportKitti, PcdPaddingAndBytesOfIntensityAreTaken) {
  fs::remove(source_.file("velodyne", 1, "bin"));
  write_pcd_scan(source_.file("velodyne", 1, "pcd"),
                 {{"_", 1, 'U', 4}, {"intensity", 1, 'U'}, {"ring", 1, 'U'}, {"_", 1, 'U', 2}},
                 [](PcdFile& f, int i) {
                   f.put(std::uint32_t{0xFFFFFFFF});
                   f.put(static_cast<std::uint8_t>(200 + i));
                   f.put(static_cast<std::uint8_t>(30 + i));
                   f.put(std::uint16_t{0xFFFF});
                 });
  import();
  const auto points = read_lidar_points(out() / "sequence/lidar/000001.pcd");
  ASSERT_EQ(points.size(), 3u);
  EXPECT_EQ(points[2].z, 5);
  EXPECT_EQ(points[2].intensity, 202);
  EXPECT_EQ(points[2].ring, 32);
  EXPECT_EQ(points[2].offset_ns, 100'000'000u);
}

// 32 bits of nanoseconds hold no later point.
TEST_F(ImportKitti, ScansThatAreTooSlowForPointsTimesAreRefused) {
  for (const char* name : {"image_02", "calib", "poses", "label_02"}) fs::remove_all(source_.folder / name);
  fs::create_directories(source_.folder / "times");
  write_text(source_.folder / "times/0007.txt", "0\n4.2\n8.4\n12.6\n");
  import();
  fs::remove_all(out());
  write_text(source_.folder / "times/0007.txt", "0\n5\n10\n15\n");
  EXPECT_NE(input_error([&] { import(); }).find("velodyne/0007: a scan comes every 5 s"), std::string::npos);
  EXPECT_FALSE(fs::exists(out()));
}

TEST_F(ImportKitti, SaysWhereLabelsContradictEachOther) {
  const fs::path labels = source_.folder / "label_02/0007.txt";
  std::string text = read_text(labels);
  text.replace(text.find("1 0 Car"), 7, "1 0 Van");
  const std::size_t third = text.find("2 0 Car");
  text.replace(text.find("1.5 1.6 4.2", third), 11, "15 16 42");
  write_text(labels, text);
  testing::internal::CaptureStderr();
  import();
  const std::string line = "uniquadric: " + labels.string() + ": ";
  EXPECT_EQ(
      testing::internal::GetCapturedStderr(),
      line + "track 0 is object 4 here, where ids begin at 1\n" + line +
          "track 0 is a Car, in frame 1 a Van: taken as the former\n" + line +
          "the box of track 0 in 1 of 4 frames, 2 the first, is off its median size by more than a factor "
          "2: taken is the median\n");
}

TEST_F(ImportKitti, RefusesWhatItCannotBelieve) {
  const fs::path calib = "calib/0007.txt", labels = "label_02/0007.txt", poses = "poses/0007.txt";
  expect_refused(calib, "P2:", "P9:", ": has no P2");
  expect_refused(calib, " 3.500000000000", " 1e7", ":2: P2: expected a principal point from 0 to 16384 px");
  expect_refused(calib, "R_rect 0.9", "R_rect 0.8", ":3: the matrix is no rotation");
  expect_refused(calib, "Tr_velo_cam ", "Tr_velo_cam x ", ":4: 'x' is not a finite number");
  expect_refused(labels, "1 0 Car", "4 0 Car", ":3: frame '4' is no whole number from 0 to 3");
  expect_refused(labels, "1 0 Car", "0 0 Car", ":3: track 0 stands twice in frame 0");
  expect_refused(labels, "1.5 1.6 4.2", "1.5 0 4.2", ":2: a box of 4.2 x 0 x 1.5 m");
  expect_refused(labels, " 0.3\n", " 17\n", ":2: a rotation_y of 17 is no angle in radians");
  expect_refused(labels, "1.5 1.6 4.2", "1.5 4.2", ":2: expected 17 fields, found 16");
  expect_refused(poses, "\n", " 1\n", ":1: expected 12 numbers, found 13");
  expect_refused(poses, "1.000000000000", "# 1", ": has 3 lines for 4 frames");
  std::ofstream(source_.file("velodyne", 2, "bin"), std::ios::app) << "x";
  EXPECT_NE(input_error([&] { import(); }).find("000002.bin: is 33 bytes"), std::string::npos);
  source_.write_scan(2, {});
  write_png(source_.file("image_02", 2, "png"), cv::Mat(7, 8, CV_8UC3));
  EXPECT_NE(input_error([&] { import(); }).find("000002.png: is 8x7, the camera says 8x6"),
            std::string::npos);
  fs::create_directories(source_.folder / "velodyne/0008");
  EXPECT_NE(input_error([&] { import(); }).find("0007, 0008: choose one by --drive"), std::string::npos);
  EXPECT_FALSE(fs::exists(out()));
}

}  // namespace
}  // namespace uniquadric
