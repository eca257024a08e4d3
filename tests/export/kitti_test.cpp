#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <map>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "core/import/kitti.h"
#include "harness/check.h"
#include "harness/export/kitti_label.h"
#include "tests/export/exported_scene.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr double kLabelTolerance = 2e-6;  // labels have six decimals
constexpr double kPixelTolerance =
    1e-3;  // [px] what that makes of a projection at 130 px focal length and 1 m

std::map<std::string, std::vector<double>> read_calibration(const fs::path& path) {
  std::map<std::string, std::vector<double>> entries;
  for (const auto& fields : table(path, ' ')) entries[fields.at(0)] = numbers(fields, 1);
  return entries;
}

// The corners of a label's box as the devkit computes them (computeBox3D.m).
Eigen::Matrix<double, 3, 8> devkit_corners(const std::vector<std::string>& label) {
  const double h = std::stod(label[10]), w = std::stod(label[11]), l = std::stod(label[12]);
  const double ry = std::stod(label[16]);
  Eigen::Matrix3d R;
  R << std::cos(ry), 0, std::sin(ry), 0, 1, 0, -std::sin(ry), 0, std::cos(ry);
  Eigen::Matrix<double, 3, 8> corners;
  corners.row(0) << l / 2, l / 2, -l / 2, -l / 2, l / 2, l / 2, -l / 2, -l / 2;
  corners.row(1) << 0, 0, 0, 0, -h, -h, -h, -h;
  corners.row(2) << w / 2, -w / 2, -w / 2, w / 2, w / 2, -w / 2, -w / 2, w / 2;
  return (R * corners).colwise() +
         Eigen::Vector3d(std::stod(label[13]), std::stod(label[14]), std::stod(label[15]));
}

TEST_F(Export, KittiVelodynePointsLandOnTheBallsMask) {
  const fs::path out = run("kitti-tracking");
  auto calibration = read_calibration(out / "calib/0000.txt");
  ASSERT_EQ(calibration.size(), 7u);
  const Matrix34d P2 = matrix34(calibration["P2:"]),
                  camera_from_velodyne = matrix34(calibration["Tr_velo_cam"]);
  EXPECT_EQ(calibration["R_rect"], (std::vector<double>{1, 0, 0, 0, 1, 0, 0, 0, 1}));
  EXPECT_FALSE(fs::exists(out / "velodyne/0000/000000.bin"));  // taken before the first scan
  int points = 0;
  for (int frame = 1; frame < kFrames; ++frame) {
    const std::string bytes = bytes_of(out / fmt::format("velodyne/0000/{:06}.bin", frame));
    const auto& scan = scans_[static_cast<std::size_t>(frame - 1)];
    ASSERT_EQ(bytes.size(), scan.size() * 16);
    const cv::Mat ids = instances(frame);
    for (std::size_t i = 0; i < scan.size(); ++i) {
      float p[4];
      std::memcpy(p, bytes.data() + 16 * i, sizeof p);
      EXPECT_EQ(p[0], scan[i].x);
      EXPECT_FLOAT_EQ(p[3], scan[i].intensity / 255);
      const Eigen::Vector3d in_camera = camera_from_velodyne * Eigen::Vector4d(p[0], p[1], p[2], 1);
      EXPECT_EQ(id_at(ids, pixel_of(P2, in_camera)), kBall) << "frame " << frame << " point " << i;
      ++points;
    }
  }
  EXPECT_EQ(points, 600);
}

TEST_F(Export, KittiImuCalibrationChainsToTheCameras) {
  auto calibration = read_calibration(run("kitti-tracking") / "calib/0000.txt");
  const Eigen::Vector3d in_imu(0.3, -0.2, 0.5);
  const Eigen::Vector3d in_velodyne = matrix34(calibration["Tr_imu_velo"]) * in_imu.homogeneous();
  const Eigen::Vector3d in_camera = matrix34(calibration["Tr_velo_cam"]) * in_velodyne.homogeneous();
  EXPECT_LT((in_camera - sequence_.imu->camera_from_imu * in_imu).norm(), 1e-14);  // double rounding
}

TEST_F(Export, KittiLabelsEncloseTheObjectAndItsMask) {
  const fs::path out = run("kitti-tracking");
  const Matrix34d P2 = matrix34(read_calibration(out / "calib/0000.txt")["P2:"]);
  int boxes = 0;
  for (const auto& label : table(out / "label_02/0000.txt", ' ')) {
    ASSERT_EQ(label.size(), 17u);
    const int frame = std::stoi(label[0]), id = std::stoi(label[1]);
    const auto corners = devkit_corners(label);
    Eigen::Array2d low = Eigen::Array2d::Constant(INFINITY), high = -low;
    for (int i = 0; i < 8; ++i) {
      const Eigen::Array2d pixel = pixel_of(P2, corners.col(i)).array();
      low = low.min(pixel), high = high.max(pixel);
    }
    const cv::Rect mask = cv::boundingRect(instances(frame) == id);
    EXPECT_EQ(numbers(label, 6)[0], mask.x);
    EXPECT_EQ(numbers(label, 6)[1], mask.y);
    EXPECT_EQ(numbers(label, 6)[2], mask.x + mask.width - 1);
    EXPECT_EQ(numbers(label, 6)[3], mask.y + mask.height - 1);
    EXPECT_LE(low.x(), mask.x + kPixelTolerance);
    EXPECT_LE(low.y(), mask.y + kPixelTolerance);
    EXPECT_GE(high.x(), mask.x + mask.width - 1 - kPixelTolerance);
    EXPECT_GE(high.y(), mask.y + mask.height - 1 - kPixelTolerance);
    // each face touches a corner of the object's own box, and none lies outside
    const Eigen::Matrix3d axes =
        (Eigen::Matrix3d() << (corners.col(1) - corners.col(2)).normalized(),
         (corners.col(4) - corners.col(0)).normalized(), (corners.col(0) - corners.col(1)).normalized())
            .finished();
    const Ellipsoid& object = truth_of(id, frame).ellipsoid;
    const Pose camera_from_object =
        truth_.camera[static_cast<std::size_t>(frame)].pose.inverse() * object.world_from_object;
    const Eigen::Vector3d center = corners.rowwise().mean();
    const Eigen::Vector3d reach =
        (axes.transpose() * camera_from_object.rotation.toRotationMatrix()).cwiseAbs() * object.semi_axes_m;
    EXPECT_LT((center - camera_from_object.translation).norm(), kLabelTolerance);
    EXPECT_NEAR(2 * reach.x(), std::stod(label[12]), kLabelTolerance);
    EXPECT_NEAR(2 * reach.y(), std::stod(label[10]), kLabelTolerance);
    EXPECT_NEAR(2 * reach.z(), std::stod(label[11]), kLabelTolerance);
    ++boxes;
  }
  EXPECT_EQ(boxes, 2 * kFrames);
}

TEST_F(Export, KittiPosesStartAtTheIdentity) {
  const auto rows = table(run("kitti-tracking") / "poses/0000.txt", ' ');
  ASSERT_EQ(rows.size(), 4u);
  EXPECT_LT((matrix34(numbers(rows[0])) - Matrix34d::Identity()).norm(), 1e-14);  // double rounding
  const Eigen::Matrix4d expected = truth_.camera[0].pose.matrix().inverse() * truth_.camera[3].pose.matrix();
  EXPECT_LT((matrix34(numbers(rows[3])) - expected.topRows<3>()).norm(), 1e-12);  // an inverse's rounding
}

// Sensors come back as they were, and objects as the boxes of their labels: their centres exactly.
TEST_F(Export, KittiComesBackByImport) {
  const fs::path back = folder() / "back";
  ImportKittiOptions options;
  options.quiet = true;
  import_kitti_tracking(run("kitti-tracking"), options, back);
  const Sequence sequence = open_sequence(back);
  EXPECT_EQ(sequence.camera.matrix(), sequence_.camera.matrix());
  ASSERT_EQ(sequence.frames.size(), std::size_t{kFrames});
  ASSERT_EQ(sequence.scans.size(), scans_.size());
  constexpr double kRounding = 1e-12;
  EXPECT_LT((sequence.lidar->camera_from_lidar.matrix() - sequence_.lidar->camera_from_lidar.matrix()).norm(),
            kRounding);
  for (std::size_t i = 0; i < scans_.size(); ++i) {
    const auto points = read_lidar_points(sequence.folder / sequence.scans[i].file);
    ASSERT_EQ(points.size(), scans_[i].size());
    for (std::size_t j = 0; j < points.size(); ++j) {
      EXPECT_EQ(points[j].y, scans_[i][j].y);
      EXPECT_FLOAT_EQ(points[j].intensity, scans_[i][j].intensity);
      EXPECT_EQ(sequence.scans[i].stamp_ns + points[j].offset_ns, sequence.frames[i + 1].stamp_ns);
    }
  }
  EXPECT_EQ(check_sequence(back), std::vector<std::string>());
  const Tracks truth = read_tracks(back / "truth");
  ASSERT_EQ(truth.objects.size(), 2u);
  for (const ObjectTrack& track : truth.objects) {
    ASSERT_EQ(track.states.size(), std::size_t{kFrames});
    for (int i = 0; i < kFrames; ++i) {
      EXPECT_EQ(truth.camera[i].stamp_ns, truth_.camera[i].stamp_ns);
      const Pose back_in_camera =
          truth.camera[i].pose.inverse() * track.states[i].ellipsoid.world_from_object;
      const Pose in_camera =
          truth_.camera[i].pose.inverse() * truth_of(track.id, i).ellipsoid.world_from_object;
      EXPECT_LT((back_in_camera.translation - in_camera.translation).norm(), kLabelTolerance);
    }
  }
}

// An object upright in the camera frame, turned by ry: its x axis forward, z up (the camera's -y).
ObjectAtFrame upright(const ObjectDescription& description, double ry, const Eigen::Vector3d& center) {
  Eigen::Matrix3d camera_from_upright;
  camera_from_upright << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  ObjectAtFrame object;
  object.object = &description;
  object.camera_from_object.rotation =
      Eigen::AngleAxisd(ry, Eigen::Vector3d::UnitY()) * Eigen::Quaterniond(camera_from_upright);
  object.camera_from_object.translation = center;
  object.visibility = {100, 100, 1.0, false};
  return object;
}

TEST(KittiLabel, UprightObjectKeepsItsSizeAndHeading) {
  const ObjectDescription car{7, "car", {2.25, 0.9, 0.75}, "car", ""};
  int cases = 0;
  for (const double ry : {0.0, 0.7, 1.5, 3.0, -0.4, -2.9}) {
    const KittiBox box = kitti_box(upright(car, ry, {1, 0.5, 10}));
    EXPECT_NEAR(box.rotation_y_rad, ry, 1e-12);
    EXPECT_LT((Eigen::Vector3d(box.length_m, box.width_m, box.height_m) - 2 * car.semi_axes_m).norm(), 1e-12);
    EXPECT_LT((box.bottom_center_m - Eigen::Vector3d(1, 0.5 + 0.75, 10)).norm(), 1e-12);
    ++cases;
  }
  EXPECT_EQ(cases, 6);
}

std::vector<std::string> label_of(const ObjectAtFrame& object) {
  const std::string line = kitti_label_line(Camera{}, 3, object, {10, 20, 30, 40});
  std::vector<std::string> fields;
  std::istringstream in(line);
  for (std::string field; in >> field;) fields.push_back(field);
  return fields;
}

TEST(KittiLabel, AlphaIsTheHeadingSeenAlongTheRay) {
  const ObjectDescription car{7, "car", {2.25, 0.9, 0.75}, "car", ""};
  // straight ahead the two angles are one; 45 degrees to the right they differ by those
  EXPECT_NEAR(std::stod(label_of(upright(car, 0.7, {0, 0, 10}))[5]), 0.7, kLabelTolerance);
  EXPECT_NEAR(std::stod(label_of(upright(car, 0.7, {10, 0, 10}))[5]), 0.7 - std::numbers::pi / 4,
              kLabelTolerance);
  EXPECT_NEAR(std::stod(label_of(upright(car, -3.0, {10, 0, 10}))[5]),
              2 * std::numbers::pi - 3 - std::numbers::pi / 4,
              kLabelTolerance);  // stays within +-pi
}

TEST(KittiLabel, LevelsFollowVisibility) {
  const ObjectDescription car{7, "car", {2.25, 0.9, 0.75}, "car", ""},
      tram{8, "s", {9, 1, 1}, "carriage", ""}, box{9, "b", {1, 1, 1}, "box", ""};
  EXPECT_EQ(kitti_type(car), "Car");
  EXPECT_EQ(kitti_type(tram), "Tram");
  EXPECT_EQ(kitti_type(box), "Misc");
  ObjectAtFrame object = upright(car, 0, {0, 0, 10});
  const auto occlusion = [&](double fraction, std::int64_t silhouette_px) {
    object.visibility = {1, silhouette_px, fraction, false};
    EXPECT_EQ(label_of(object)[3], "0");
    return label_of(object)[4];
  };
  EXPECT_EQ(occlusion(1, 100), "0");
  EXPECT_EQ(occlusion(0.7, 100), "1");
  EXPECT_EQ(occlusion(0.2, 100), "2");
  EXPECT_EQ(occlusion(0, 0), "3");
  // 640 px wide, fx 525: at 10 m the image ends at 6.09 m; of 4.5 m of car 3.3 or 1.3 m are inside
  const auto truncation = [&](double x) {
    object.camera_from_object.translation = {x, 0, 10};
    object.visibility.touches_border = true;
    return label_of(object)[3];
  };
  EXPECT_EQ(truncation(5), "1");
  EXPECT_EQ(truncation(7), "2");
}

}  // namespace
}  // namespace uniquadric
