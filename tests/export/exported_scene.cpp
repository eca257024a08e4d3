#include "tests/export/exported_scene.h"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "core/base/files.h"
#include "simulator/simulate.h"
#include "tests/harness/program.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr int kPointsPerScan = 200;
constexpr std::int64_t kPeriodNs = 100'000'000;

// Points over the cap of 45 degrees about the direction from the ball to the camera.
std::vector<Eigen::Vector3d> cap_of_ball(const Eigen::Vector3d& center, double radius_m,
                                         const Eigen::Vector3d& eye) {
  const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), eye - center);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < kPointsPerScan; ++i) {
    const double z = 1 - (1 - std::sqrt(0.5)) * (i + 0.5) / kPointsPerScan, azimuth = i * 2.399963;
    const double r = std::sqrt(1 - z * z);
    points.push_back(center +
                     radius_m * (turn * Eigen::Vector3d(r * std::cos(azimuth), r * std::sin(azimuth), z)));
  }
  return points;
}

}  // namespace

Export::Export() {
  const fs::path scene = folder() / "scene.yaml";
  std::string yaml = small_scene_yaml();
  const std::string hidden = "[0.6, 0.2, 0.3]";  // there the box stands before the ball
  yaml.replace(yaml.find(hidden), hidden.size(), "[0.45, -0.55, 0.35]");
  write_text(scene, yaml +
                        "imu: {rate_hz: 100, body_from_imu: {position_m: [0.1, 0.02, -0.03], "
                        "rpy_deg: [10, -5, 20]}}\n");
  SimulateOptions options;
  options.quiet = true;
  options.threads = 1;
  simulate(load_scene(scene), options, data());
  sequence_ = open_sequence(data() / "sequence");
  truth_ = read_tracks(data() / "truth");

  LidarCalibration lidar;
  lidar.pattern = "by_hand";
  lidar.rate_hz = 10;
  lidar.camera_from_lidar.rotation = Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5) *
                                     Eigen::Quaterniond(Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitZ()));
  lidar.camera_from_lidar.translation = {0.05, -0.1, 0.02};
  sequence_.lidar = lidar;
  fs::create_directories(sequence_.folder / "lidar");
  for (int frame = 1; frame < kFrames; ++frame) {
    const ObjectState& ball = truth_of(kBall, frame);
    const Pose world_from_camera = truth_.camera[frame].pose;
    const Pose lidar_from_world = (world_from_camera * lidar.camera_from_lidar).inverse();
    std::vector<LidarPoint> points;
    for (const auto& p : cap_of_ball(ball.ellipsoid.world_from_object.translation,
                                     ball.ellipsoid.semi_axes_m.x(), world_from_camera.translation)) {
      const Eigen::Vector3f q = (lidar_from_world * p).cast<float>();
      const auto i = static_cast<std::uint32_t>(points.size());
      points.push_back({q.x(), q.y(), q.z(), static_cast<float>(i % 256), i * 500'000,
                        static_cast<std::uint16_t>(i % 6), static_cast<std::uint8_t>(i % 2 * 16)});
    }
    const SequenceScan scan{sequence_.frames[frame].stamp_ns - kPeriodNs / 2,
                            fmt::format("lidar/{}.pcd", frame)};
    write_lidar_points(sequence_.folder / scan.file, points);
    sequence_.scans.push_back(scan);
    scans_.push_back(points);
  }
  rewrite_index();
}

void Export::rewrite_index() {
  write_sequence_index(sequence_.folder, sequence_);
}

fs::path Export::run(const std::string& format, ExportOptions options) {
  options.quiet = true;
  const fs::path out = folder() / ("exported-" + format);
  export_sequence(format, sequence_.folder, out, options);
  return out;
}

cv::Mat Export::instances(int frame) const {
  return cv::imread((data() / "truth/instances" / fmt::format("{:06}.png", frame)).string(),
                    cv::IMREAD_UNCHANGED);
}

cv::Mat Export::sequence_image(const fs::path& file) const {
  return cv::imread((sequence_.folder / file).string(), cv::IMREAD_UNCHANGED);
}

const ObjectState& Export::truth_of(int object, int frame) const {
  return truth_.objects.at(static_cast<std::size_t>(object - 1)).states.at(static_cast<std::size_t>(frame));
}

std::vector<std::vector<std::string>> table(const fs::path& path, char separator) {
  std::ifstream in(path);
  EXPECT_TRUE(in) << path;
  std::vector<std::vector<std::string>> rows;
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line[0] == '#') continue;
    rows.emplace_back();
    std::istringstream fields(line);
    for (std::string field; std::getline(fields, field, separator);) rows.back().push_back(field);
  }
  return rows;
}

std::vector<double> numbers(const std::vector<std::string>& fields, std::size_t begin) {
  std::vector<double> values;
  for (std::size_t i = begin; i < fields.size(); ++i) values.push_back(std::stod(fields[i]));
  return values;
}

Matrix34d matrix34(const std::vector<double>& values) {
  EXPECT_EQ(values.size(), 12u);
  return Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(values.data());
}

Eigen::Vector2d pixel_of(const Matrix34d& P, const Eigen::Vector3d& point) {
  const Eigen::Vector3d p = P * point.homogeneous();
  return p.head<2>() / p.z();
}

int id_at(const cv::Mat& ids, const Eigen::Vector2d& pixel) {
  const int u = static_cast<int>(std::lround(pixel.x())), v = static_cast<int>(std::lround(pixel.y()));
  if (u < 0 || v < 0 || u >= ids.cols || v >= ids.rows) return -1;
  return ids.at<std::uint16_t>(v, u);
}

std::string bytes_of(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  EXPECT_TRUE(in) << path;
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace uniquadric
