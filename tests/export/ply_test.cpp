#include <cstring>
#include <opencv2/core.hpp>
#include <sstream>

#include "tests/export/exported_scene.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

struct PlyFile {
  std::size_t vertices = 0, point_size = 0;
  std::vector<std::string> properties;  // "float x"
  std::string data;

  template <typename T>
  T at(std::size_t vertex, std::size_t offset) const {
    T value;
    std::memcpy(&value, data.data() + vertex * point_size + offset, sizeof value);
    return value;
  }
};

PlyFile read_ply(const fs::path& path) {
  const std::string text = bytes_of(path), end = "end_header\n";
  PlyFile ply;
  const std::size_t begin = text.find(end) + end.size();
  std::istringstream header(text.substr(0, begin));
  std::string line;
  std::getline(header, line);
  EXPECT_EQ(line, "ply");
  std::getline(header, line);
  EXPECT_EQ(line, "format binary_little_endian 1.0");
  while (std::getline(header, line)) {
    if (line.starts_with("element vertex ")) ply.vertices = std::stoul(line.substr(15));
    if (!line.starts_with("property ")) continue;
    ply.properties.push_back(line.substr(9));
    const std::string type = ply.properties.back().substr(0, ply.properties.back().find(' '));
    ply.point_size += type == "float" || type == "uint" ? 4 : type == "ushort" ? 2 : 1;
  }
  ply.data = text.substr(begin);
  EXPECT_EQ(ply.data.size(), ply.vertices * ply.point_size);
  return ply;
}

TEST_F(Export, PlyPointsProjectBackToTheirPixels) {
  ExportOptions options;
  options.frame_stride = 3;
  options.pixel_stride = 4;
  const PlyFile ply = read_ply(run("ply", options) / "depth.ply");
  EXPECT_EQ(ply.properties, (std::vector<std::string>{"float x", "float y", "float z", "uchar red",
                                                      "uchar green", "uchar blue", "ushort instance"}));
  std::size_t vertex = 0;
  for (const int frame : {0, 3}) {
    const auto i = static_cast<std::size_t>(frame);
    const cv::Mat depth = sequence_image(sequence_.frames[i].depth), ids = instances(frame),
                  color = sequence_image(sequence_.frames[i].rgb);
    const Eigen::Matrix4d camera_from_world = truth_.camera[i].pose.matrix().inverse();
    for (int v = 0; v < depth.rows; v += 4)
      for (int u = 0; u < depth.cols; u += 4) {
        if (depth.at<std::uint16_t>(v, u) == 0) continue;
        ASSERT_LT(vertex, ply.vertices);
        const Eigen::Vector3d p(ply.at<float>(vertex, 0), ply.at<float>(vertex, 4), ply.at<float>(vertex, 8));
        const Eigen::Vector4d q = camera_from_world * p.homogeneous();
        constexpr double kFloat = 2e-6;  // [m] single precision at a few metres
        EXPECT_NEAR(q.z(), depth.at<std::uint16_t>(v, u) / sequence_.depth_units_per_m, kFloat);
        EXPECT_NEAR(130 * q.x() / q.z() + 79.5, u, 1e-3);
        EXPECT_NEAR(130 * q.y() / q.z() + 59.5, v, 1e-3);
        const auto& c = color.at<cv::Vec3b>(v, u);
        EXPECT_EQ(ply.at<unsigned char>(vertex, 12), c[2]);
        EXPECT_EQ(ply.at<unsigned char>(vertex, 13), c[1]);
        EXPECT_EQ(ply.at<unsigned char>(vertex, 14), c[0]);
        EXPECT_EQ(ply.at<std::uint16_t>(vertex, 15), ids.at<std::uint16_t>(v, u));
        ++vertex;
      }
  }
  EXPECT_EQ(vertex, ply.vertices);
  EXPECT_GT(vertex, 1000u);
}

TEST_F(Export, PlyScansHoldThePointsAsTheyWereMeasured) {
  const fs::path out = run("ply");
  for (std::size_t i = 0; i < scans_.size(); ++i) {
    const PlyFile ply = read_ply(out / ("lidar/00000" + std::to_string(i) + ".ply"));
    ASSERT_EQ(ply.vertices, scans_[i].size());
    ASSERT_EQ(ply.properties.size(), 7u);
    for (std::size_t k = 0; k < ply.vertices; ++k) {
      const LidarPoint& p = scans_[i][k];
      EXPECT_EQ(ply.at<float>(k, 0), p.x);
      EXPECT_EQ(ply.at<float>(k, 8), p.z);
      EXPECT_EQ(ply.at<float>(k, 12), p.intensity);
      EXPECT_EQ(ply.at<std::uint32_t>(k, 16), p.offset_ns);
      EXPECT_EQ(ply.at<std::uint16_t>(k, 20), p.ring);
      EXPECT_EQ(ply.at<std::uint8_t>(k, 22), p.tag);
    }
  }
}

TEST_F(Export, PlyRefusesASequenceWithoutAnyPoint) {
  sequence_.lidar.reset();
  sequence_.given_camera.reset();
  sequence_.scans.clear();
  fs::remove(sequence_.folder / "camera_given.tum");
  fs::remove_all(data() / "truth");
  rewrite_index();
  EXPECT_NE(input_error([&] { run("ply"); }).find("neither LiDAR scans nor depth"), std::string::npos);
}

}  // namespace
}  // namespace uniquadric
